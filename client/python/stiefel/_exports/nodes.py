"""The attitudes that an export writes, and what a reader loses by rounding."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Optional

import numpy as np
from numpy.typing import NDArray

from stiefel._given.instants import Instant, instant
from stiefel._results.body import quaternions
from stiefel._results.html import Shown

Trajectory = Any  # a `stiefel.Trajectory`


@dataclass(frozen=True, repr=False)
class Export(Shown):
    """What was written, and how far the times in it are from those of the samples."""

    files: tuple[str, ...]
    format: str
    samples: int
    time_rounding: float  #: the largest difference between the time of a sample and that in the file, in seconds

    def __repr__(self) -> str:
        rounding = "exact" if self.time_rounding == 0 else f"rounded by at most {self.time_rounding:.1e} s"
        count = f"{self.samples} sample{'s' if self.samples != 1 else ''}"
        return f"<stiefel.Export of {count} as {self.format}: {', '.join(self.files)}\n  times {rounding}>"


@dataclass(frozen=True)
class Nodes:
    """Samples in the order of time."""

    time: NDArray[np.float64]  #: seconds after the epoch
    quaternion: NDArray[np.float64]  #: w, x, y, z, body to space, with a continuous sign
    rate: Optional[NDArray[np.float64]]  #: the angular velocity in rad/s and body axes; None if the trajectory has none
    epoch: Instant


def nodes_of(run: Trajectory, epoch: Any = None) -> Nodes:
    """Returns the samples of a trajectory. `epoch`: the instant of time 0 if the scene has none. Raises ValueError if there
    is no attitude, no epoch, or an ensemble."""
    given = run.epoch if epoch is None else epoch
    if given is None:
        raise ValueError("epoch: absent: give the instant of time 0, here or as `epoch` of the scene")
    order = np.argsort(run.time, kind="stable")
    order = order[np.r_[True, np.diff(run.time[order]) > 0]] if len(order) else order
    q = quaternions(run.fields, run._side)
    if q.ndim != 2:
        raise ValueError(f"the attitudes of an ensemble have the shape {q.shape}: an export takes one motion, such as that of run.member(0)")
    q = q[order]
    if not len(q):
        raise ValueError("the trajectory has no samples")
    q[1:] *= np.cumprod(np.where((q[1:] * q[:-1]).sum(axis=1) < 0, -1, 1))[:, None]
    rate = run.fields.get("angular_velocity")
    return Nodes(run.time[order], q, None if rate is None else np.asarray(rate, float)[order], instant("epoch", given))
