"""Attitude messages of CCSDS 504.0: AEM, samples, and APM, one state. Both have the keyword = value notation.

The quaternion of CCSDS turns the axes of frame A into those of frame B. With space as A and body as B its Q1, Q2, Q3, QC are
x, y, z, w of the quaternion of this package, which takes body to space.
"""
from __future__ import annotations

import datetime
import os
from fractions import Fraction
from typing import Any, Optional

import numpy as np

from stiefel._exports.nodes import Export, Nodes, nodes_of, written
from stiefel._given.instants import Instant
from stiefel._results.attitude import angle_between
from stiefel.version import __version__

Trajectory = Any  # a `stiefel.Trajectory`
_SYSTEMS = {"UTC", "TAI", "TT", "TDB", "TCB", "TCG", "UT1", "GPS"}
_DIGITS = 12  #: of the seconds: picoseconds


def to_aem(run: Trajectory, file: "str | os.PathLike[str]", *, epoch: Any = None, object_name: str = "BODY",
           object_id: str = "UNKNOWN", center: Optional[str] = None, frame: str = "EME2000", body_frame: str = "SC_BODY_1",
           originator: str = "STIEFEL", created: Optional[datetime.datetime] = None) -> Export:
    """Writes an AEM of version 2.0 with quaternions and angular velocities (deg/s, in body axes), with which readers
    interpolate better; they are missing only where neither a field nor the scene tells them. `epoch`: the instant of time 0 if
    the scene has none. `frame`: the name of the space axes. `center`: the name of the central body. `created`: the date of the
    message; by default now."""
    nodes = nodes_of(run, epoch)
    stamps = [_stamp(one) for one in nodes.instants()]
    export = Export((os.fspath(file),), "CCSDS AEM 2.0", len(stamps), _rounding(nodes), _interpolation_error(nodes))
    kind = ["ATTITUDE_TYPE = QUATERNION"]
    rates: list[list[float]] = [[]] * len(stamps)
    if nodes.body_rate is not None:
        kind = ["ATTITUDE_TYPE = QUATERNION/ANGVEL", f"ANGVEL_FRAME = {body_frame}"]
        rates = np.degrees(nodes.body_rate).tolist()
    lines = [*_header("AEM", "2.0", originator, created), "", "META_START", *_comments(export),
             *_object(object_name, object_id, center), f"REF_FRAME_A = {frame}", f"REF_FRAME_B = {body_frame}",
             f"TIME_SYSTEM = {_system(nodes.epoch)}", f"START_TIME = {stamps[0]}", f"STOP_TIME = {stamps[-1]}", *kind,
             "INTERPOLATION_METHOD = LINEAR", "INTERPOLATION_DEGREE = 1", "META_STOP", "", "DATA_START"]
    lines += [" ".join([stamp, *map(repr, (x, y, z, w, *rate))])
              for stamp, (w, x, y, z), rate in zip(stamps, nodes.quaternion.tolist(), rates)]
    written(file, "\n".join([*lines, "DATA_STOP", ""]))
    return export


def to_apm(run: Trajectory, file: "str | os.PathLike[str]", *, at: int = -1, epoch: Any = None, object_name: str = "BODY",
           object_id: str = "UNKNOWN", center: Optional[str] = None, frame: str = "EME2000", body_frame: str = "SC_BODY_1",
           originator: str = "STIEFEL", created: Optional[datetime.datetime] = None) -> Export:
    """Writes an APM of version 2.0 with attitude, angular velocity (deg/s, in body axes) and, of a scene with `body`, the
    inertia. `at`: the index of the sample. The other arguments are those of `to_aem`."""
    sample = range(len(run))[at]
    nodes = nodes_of(run[sample:sample + 1], epoch)
    export = Export((os.fspath(file),), "CCSDS APM 2.0", 1, _rounding(nodes), float("nan"))
    w, x, y, z = nodes.quaternion[0].tolist()
    frames = [f"REF_FRAME_A = {frame}", f"REF_FRAME_B = {body_frame}"]
    lines = [*_header("APM", "2.0", originator, created), "", *_object(object_name, object_id, center),
             f"TIME_SYSTEM = {_system(nodes.epoch)}", "", *_comments(export), f"EPOCH = {_stamp(nodes.instants()[0])}",
             "QUAT_START", *frames, f"Q1 = {x!r}", f"Q2 = {y!r}", f"Q3 = {z!r}", f"QC = {w!r}", "QUAT_STOP"]
    if nodes.body_rate is not None:
        rates = zip("XYZ", np.degrees(nodes.body_rate[0]).tolist())
        lines += ["ANGVEL_START", *frames, f"ANGVEL_FRAME = {body_frame}",
                  *(f"ANGVEL_{axis} = {rate!r} [deg/s]" for axis, rate in rates), "ANGVEL_STOP"]
    lines += _inertia(run.scene.get("body") if run.origin is not None else None, body_frame)
    written(file, "\n".join([*lines, ""]))
    return export


def _interpolation_error(nodes: Nodes) -> float:
    """Returns an upper estimate for readers that turn along the shortest turn, and for Orekit. Between samples that are turned
    by the angle a against each other Orekit is off by up to 0.27 a^2 with quaternions alone and by 0.008 a^4 with angular
    velocities, as measured; from a quarter of a turn on it may take another branch."""
    error = nodes.interpolation_error()
    if len(nodes.time) < 2:
        return error
    angle = float(angle_between(nodes.quaternion[1:], nodes.quaternion[:-1]).max())
    of_orekit = angle**2 / 3 if nodes.body_rate is None else angle**4 / 100
    return min(error + of_orekit, np.pi) if angle < np.pi / 2 else np.pi


def _header(kind: str, version: str, originator: str, created: Optional[datetime.datetime]) -> list[str]:
    now = (created or datetime.datetime.now(datetime.timezone.utc)).strftime("%Y-%m-%dT%H:%M:%S")
    return [f"CCSDS_{kind}_VERS = {version}", f"COMMENT written by stiefel {__version__}", f"CREATION_DATE = {now}",
            f"ORIGINATOR = {originator}"]


def _object(name: str, id: str, center: Optional[str]) -> list[str]:
    return [f"OBJECT_NAME = {name}", f"OBJECT_ID = {id}"] + ([f"CENTER_NAME = {center}"] if center else [])


def _comments(export: Export) -> list[str]:
    return [f"COMMENT {line.strip(' <>')}" for line in repr(export).splitlines()[1:]]


def _inertia(body: Any, frame: str) -> list[str]:
    """Returns the block of the inertia matrix, whose IXY, IXZ, IYZ are the entries of the matrix."""
    if not body:
        return []
    entries = body.get("inertia_tensor") or [*body["moments"], 0.0, 0.0, 0.0]
    names = ("IXX", "IYY", "IZZ", "IXY", "IXZ", "IYZ")
    return ["INERTIA_START", "COMMENT IXY, IXZ and IYZ are entries of the inertia matrix", f"INERTIA_REF_FRAME = {frame}",
            *(f"{name} = {float(entry)!r} [kg*m**2]" for name, entry in zip(names, entries)), "INERTIA_STOP"]


def _system(epoch: Instant) -> str:
    if epoch.scale not in _SYSTEMS:
        raise ValueError(f"epoch: CCSDS has no time system {epoch.scale}")
    return epoch.scale


def _stamp(one: Instant) -> str:
    """Returns an instant as CCSDS writes it, to picoseconds."""
    picoseconds = round(one.seconds * 10**_DIGITS)
    rounded = Instant(one.day, Fraction(picoseconds, 10**_DIGITS), one.scale)
    text = str(rounded).partition(" ")[0]
    return text


def _rounding(nodes: Nodes) -> float:
    """Returns the largest difference between a time and that of its stamp."""
    return max(float(abs(one.seconds - Fraction(round(one.seconds * 10**_DIGITS), 10**_DIGITS))) for one in nodes.instants())
