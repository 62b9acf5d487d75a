"""Compares the checksums that the server sends in its replies with the numbers received."""
from __future__ import annotations

from typing import Any, Iterable, Iterator

import numpy as np

from stiefel import v1 as pb
from stiefel.crc32c import crc32c
from stiefel.errors import CorruptReply

_LISTS = ("inertia", "inertia_u", "inertia_v")
_BODY_LISTS = ("inertia_tensor", "moments", "attitude", "angular_velocity")


def verify(message: Any, parts: Iterable[bytes], what: str) -> None:
    """Raises CorruptReply if the message has a checksum other than that of `parts`, which stand in the order of the
    .proto file."""
    if message.HasField("checksum") and crc32c(b"".join(parts)) != message.checksum:
        raise CorruptReply(f"the checksum of {what} does not match its numbers: the reply was corrupted in transit")


def verify_sample(sample: pb.Sample) -> None:
    head = np.int64(sample.step).tobytes() + np.float64(sample.time).tobytes()
    verify(sample, [head, *_data(sample.fields)], f"the state at step {sample.step}")


def verify_batch(message: pb.StreamResponse, steps: bytes, times: bytes) -> None:
    """Checks a message of a stream. `steps` and `times`: the int64 and float64 numbers that the client has read."""
    verify(message, [steps, times, *_data(message.fields), *_data(message.scene_arrays), message.checkpoint.data],
           "a message of the stream")


def verify_diagnosis(message: pb.DiagnoseResponse) -> None:
    numbers = [number for i in message.invariants for number in (i.initial, i.value, i.drift, i.scale)]
    verify(message, [np.int64(message.step).tobytes(), _floats([message.time, *numbers])],
           f"the diagnosis of step {message.step}")


def verify_session(message: pb.Session) -> None:
    verify(message, _scene(message.scene), f"the scene of session {message.session_id}")


def verify_conversion(message: pb.ConvertResponse) -> None:
    verify(message, [*_scene(message.scene), *_data(message.scene_arrays), *_data(message.blocks)], "the conversion")


def verify_geodesic(message: pb.ConnectResponse) -> None:
    verify(message, [*_scene(message.scene), message.trajectory.value.data], f"the geodesic of pair {message.pair}")


def _data(fields: Iterable[pb.Field]) -> Iterator[bytes]:
    return (field.value.data for field in fields)


def _scene(scene: pb.Scene) -> Iterator[bytes]:
    yield from (_floats(getattr(scene, name)) for name in _LISTS)
    yield from (_floats(getattr(scene.body, name)) for name in _BODY_LISTS)
    for name in sorted(scene.initial, key=str.encode):
        yield _floats(scene.initial[name].values)
        yield _floats(scene.initial[name].imaginary)


def _floats(numbers: Iterable[float]) -> bytes:
    return np.array(numbers, "<f8").tobytes()
