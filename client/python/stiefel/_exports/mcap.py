"""MCAP files for Foxglove and others: the attitude as a frame transform, and the angular velocity."""
from __future__ import annotations

import json
import os
from fractions import Fraction
from typing import Any

from stiefel._exports.nodes import Export, nodes_of
from stiefel._given.instants import Instant
from stiefel._results.extras import imported

Trajectory = Any  # a `stiefel.Trajectory`
_EPOCH = Instant(719163, Fraction(0), "UTC")  #: 1970-01-01
_TIME = {"type": "object", "title": "time", "properties": {"sec": {"type": "integer"}, "nsec": {"type": "integer"}}}


def _object(title: str, **properties: Any) -> dict[str, Any]:
    return {"type": "object", "title": title, "properties": properties}


def _numbers(names: str) -> dict[str, Any]:
    return {"type": "object", "properties": {name: {"type": "number"} for name in names}}


_TRANSFORM = _object("foxglove.FrameTransform", timestamp=_TIME, parent_frame_id={"type": "string"},
                     child_frame_id={"type": "string"}, translation=_numbers("xyz"), rotation=_numbers("xyzw"))
_RATE = _object("stiefel.AngularVelocity", timestamp=_TIME, frame_id={"type": "string"}, vector=_numbers("xyz"))


def to_mcap(run: Trajectory, file: "str | os.PathLike[str]", *, epoch: Any = None, frame: str = "space",
            body_frame: str = "body") -> Export:
    """Writes the topics `/attitude`, with messages of the schema foxglove.FrameTransform in JSON, whose rotation takes body to
    space, and, if the trajectory has the field, `/angular_velocity` in body axes and rad/s. Times are in nanoseconds of
    Unix time. `epoch`: the instant of time 0 if the scene has none; by default 1970. Needs the package mcap."""
    writing = imported("mcap.writer", "mcap")
    default = None if run.epoch is not None or epoch is not None else "1970-01-01T00:00:00 UTC"
    nodes = nodes_of(run, epoch if default is None else default)
    path, worst = os.fspath(file), Fraction(0)
    with open(path + ".part", "wb") as out:
        writer = writing.Writer(out)
        writer.start(library="stiefel")
        channels = {}
        for topic, schema in (("/attitude", _TRANSFORM), ("/angular_velocity", _RATE)):
            id = writer.register_schema(schema["title"], "jsonschema", json.dumps(schema).encode())
            channels[topic] = writer.register_channel(topic, "json", id)
        rates = [None] * len(nodes.time) if nodes.body_rate is None else nodes.body_rate.tolist()
        for k, (one, (w, x, y, z), rate) in enumerate(zip(nodes.instants(), nodes.quaternion.tolist(), rates)):
            seconds = _unix(one)
            nanoseconds = round(seconds * 10**9)
            if nanoseconds < 0:
                raise ValueError(f"epoch: {one}: MCAP has no time before 1970")
            worst = max(worst, abs(seconds - Fraction(nanoseconds, 10**9)))
            stamp = {"sec": nanoseconds // 10**9, "nsec": nanoseconds % 10**9}
            messages: dict[str, Any] = {"/attitude": {
                "timestamp": stamp, "parent_frame_id": frame, "child_frame_id": body_frame,
                "translation": {"x": 0.0, "y": 0.0, "z": 0.0}, "rotation": {"x": x, "y": y, "z": z, "w": w}}}
            if rate is not None:
                messages["/angular_velocity"] = {"timestamp": stamp, "frame_id": body_frame, "vector": dict(zip("xyz", rate))}
            for topic, message in messages.items():
                writer.add_message(channels[topic], nanoseconds, json.dumps(message).encode(), nanoseconds, k)
        writer.finish()
    os.replace(path + ".part", path)
    return Export((path,), "MCAP", len(nodes.time), float(worst), nodes.interpolation_error())


def _unix(one: Instant) -> Fraction:
    """Returns Unix time, which counts no leap seconds; for a scale other than UTC the same date and time of day."""
    return (one.day - _EPOCH.day) * 86400 + one.seconds
