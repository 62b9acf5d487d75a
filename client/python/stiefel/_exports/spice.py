"""C-kernels of SPICE, with the kernel of a clock that counts microseconds from the first sample.

The C-matrix of SPICE takes space to the body's axes, so that its quaternion is the conjugate of that of this package.
"""
from __future__ import annotations

import math
import os
from fractions import Fraction
from typing import Any

import numpy as np

from stiefel import _rotations
from stiefel._exports.nodes import Export, nodes_of, written
from stiefel._given.instants import Instant, as_time, instant
from stiefel._results.extras import imported

Trajectory = Any  # a `stiefel.Trajectory`
TICKS = 1e6  #: of the clock in a second
_J2000 = "2000-01-01T12:00:00"


def to_ck(run: Trajectory, file: "str | os.PathLike[str]", *, instrument: int, epoch: Any = None, frame: str = "J2000",
          segment: str = "STIEFEL") -> Export:
    """Writes a C-kernel with one segment of type 3, with angular velocities if the trajectory has the field `angular_velocity`,
    and beside it FILE.tsc, the kernel of its clock.

    `instrument`: the code of the body's frame, such as -999000; its clock is that of the spacecraft `instrument` // 1000,
    -999. `frame`: the name of the space axes. `epoch`: the instant of time 0 if the scene has none. Needs spiceypy.
    """
    spice = imported("spiceypy", "spice")
    nodes = nodes_of(run, epoch)
    path, clock = os.fspath(file), f"{os.path.splitext(file)[0]}.tsc"
    spacecraft = math.ceil(instrument / 1000)
    begin = seconds_past_j2000(nodes.epoch.after(float(nodes.time[0])))
    ticks = (nodes.time - nodes.time[0]) * TICKS
    rates = np.zeros((len(ticks), 3)) if nodes.rate is None else _rotations.rotated(nodes.quaternion, nodes.rate)
    part = path + ".part"
    if os.path.exists(part):
        os.remove(part)
    handle = spice.ckopn(part, segment, 0)
    try:
        spice.ckw03(handle, ticks[0], ticks[-1], instrument, frame, nodes.rate is not None, segment, len(ticks), ticks,
                    _rotations.inverse(nodes.quaternion), rates, 1, [ticks[0]])
    finally:
        spice.ckcls(handle)
    os.replace(part, path)
    written(clock, _clock(spacecraft, begin))
    rounding = float(max(abs(Fraction(tick) / Fraction(TICKS) - (Fraction(time) - Fraction(float(nodes.time[0]))))
                         for tick, time in zip(ticks.tolist(), nodes.time.tolist())))
    # A reader gets the time of a tick in seconds past J2000, whose rounding is larger.
    rounding += math.ulp(begin) if begin else 0.0
    return Export((path, clock), "SPICE CK, type 3", len(ticks), rounding)


def seconds_past_j2000(given: Instant) -> float:
    """Returns an instant in seconds of TDB past J2000; one in UTC as SPICE's leapseconds kernel does."""
    if given.scale != "UTC":
        return float((as_time(str(given)).tdb - as_time(f"{_J2000} TDB")).sec)
    terrestrial = given.seconds - instant("J2000", f"{_J2000}Z").seconds + Fraction(64184, 1000)  # TT - UTC was 64.184 s
    M = 6.239996 + 1.99096871e-7 * float(terrestrial)
    return float(terrestrial + Fraction(1.657e-3 * math.sin(M + 1.671e-2 * math.sin(M))))


def _clock(spacecraft: int, begin: float) -> str:
    """Returns the kernel of a clock of type 1: seconds and microseconds from the first sample, in TDB."""
    n = -spacecraft
    return f"""KPL/SCLK
\\begindata
SCLK_KERNEL_ID = ( @2000-01-01 )
SCLK_DATA_TYPE_{n} = ( 1 )
SCLK01_TIME_SYSTEM_{n} = ( 1 )
SCLK01_N_FIELDS_{n} = ( 2 )
SCLK01_MODULI_{n} = ( 10000000000 1000000 )
SCLK01_OFFSETS_{n} = ( 0 0 )
SCLK01_OUTPUT_DELIM_{n} = ( 1 )
SCLK_PARTITION_START_{n} = ( 0.0 )
SCLK_PARTITION_END_{n} = ( 1.0E+16 )
SCLK01_COEFFICIENTS_{n} = ( 0.0 {begin!r} 1.0 )
\\begintext
"""
