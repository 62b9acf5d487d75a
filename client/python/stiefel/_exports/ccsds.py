"""Attitude Ephemeris Messages (AEM) of CCSDS 504.0 in the keyword = value notation.

The quaternion of CCSDS turns the axes of frame A into those of frame B. With space as A and body as B its Q1, Q2, Q3, QC are
x, y, z, w of the quaternion of this package, which takes body to space.
"""
from __future__ import annotations

import datetime
import os
from fractions import Fraction
from typing import Any, Optional

import numpy as np

from stiefel._exports.nodes import Export, nodes_of, written
from stiefel.version import __version__

Trajectory = Any  # a `stiefel.Trajectory`
_SYSTEMS = {"UTC", "TAI", "TT", "TDB", "TCB", "TCG", "UT1"}


def to_aem(run: Trajectory, file: "str | os.PathLike[str]", *, epoch: Any = None, object_name: str = "BODY",
           object_id: str = "UNKNOWN", center: Optional[str] = None, frame: str = "EME2000", body_frame: str = "SC_BODY_1",
           originator: str = "STIEFEL", created: Optional[datetime.datetime] = None) -> Export:
    """Writes an AEM of version 2.0 with quaternions and, if the trajectory has the field `angular_velocity`, angular velocities
    (deg/s, in body axes), with which readers interpolate better. `epoch`: the instant of time 0 if the scene has none. `frame`:
    the name of the space axes. `center`: the name of the central body. `created`: the date of the message; by default now."""
    nodes = nodes_of(run, epoch)
    if nodes.epoch.scale not in _SYSTEMS:
        raise ValueError(f"epoch: CCSDS has no time system {nodes.epoch.scale}")
    instants = [nodes.epoch.after(float(time)) for time in nodes.time]
    stamps = [str(one).partition(" ")[0] for one in instants]
    rounding = max(float(abs(one.seconds - Fraction(round(one.seconds * 10**12), 10**12))) for one in instants)
    export = Export((os.fspath(file),), "CCSDS AEM 2.0", len(stamps), rounding)
    now = (created or datetime.datetime.now(datetime.timezone.utc)).strftime("%Y-%m-%dT%H:%M:%S")
    rates = [[]] * len(stamps) if nodes.rate is None else np.degrees(nodes.rate).tolist()
    lines = ["CCSDS_AEM_VERS = 2.0", f"COMMENT written by stiefel {__version__}", f"CREATION_DATE = {now}",
             f"ORIGINATOR = {originator}", "", "META_START", f"COMMENT {repr(export).splitlines()[1].strip(' >')}",
             f"OBJECT_NAME = {object_name}", f"OBJECT_ID = {object_id}", *([f"CENTER_NAME = {center}"] if center else []),
             f"REF_FRAME_A = {frame}", f"REF_FRAME_B = {body_frame}", f"TIME_SYSTEM = {nodes.epoch.scale}",
             f"START_TIME = {stamps[0]}", f"STOP_TIME = {stamps[-1]}",
             *(["ATTITUDE_TYPE = QUATERNION/ANGVEL", f"ANGVEL_FRAME = {body_frame}"] if rates[0] else ["ATTITUDE_TYPE = QUATERNION"]),
             "INTERPOLATION_METHOD = LINEAR", "INTERPOLATION_DEGREE = 1", "META_STOP", "", "DATA_START"]
    lines += [" ".join([stamp, *map(repr, (x, y, z, w, *rate))])
              for stamp, (w, x, y, z), rate in zip(stamps, nodes.quaternion.tolist(), rates)]
    written(file, "\n".join([*lines, "DATA_STOP", ""]))
    return export
