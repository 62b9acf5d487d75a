"""Compares the checksums that the server sends in its replies with the numbers received."""
from __future__ import annotations

from typing import Any, Iterable, Iterator

import numpy as np

from stiefel import v1 as pb
from stiefel.crc32c import crc32c
from stiefel.errors import CorruptReply

_LISTS = ("inertia", "inertia_u", "inertia_v")
_BODY_LISTS = ("inertia_tensor", "moments", "attitude", "angular_velocity")


def verify(message: Any, parts: Iterable[bytes], what: str, asked: bool, field: str = "checksum") -> None:
    """Raises CorruptReply if the message has a checksum other than that of `parts`, which stand in the order of the
    .proto file, or none although one was `asked` for. `field` is the message's field for the checksum."""
    if not message.HasField(field):
        if asked:
            raise CorruptReply(f"{what} has no checksum, which was asked for")
    elif crc32c(b"".join(parts)) != getattr(message, field):
        raise CorruptReply(f"the checksum of {what} does not match its numbers: the reply was corrupted in transit")


def verify_sample(sample: pb.Sample, asked: bool) -> None:
    head = np.int64(sample.step).tobytes() + np.float64(sample.time).tobytes()
    verify(sample, [head, *_data(sample.fields)], f"the state at step {sample.step}", asked)


def verify_batch(message: pb.StreamResponse, steps: bytes, times: bytes, asked: bool) -> None:
    """Checks a message of a stream. `steps` and `times`: the int64 and float64 numbers that the client has read."""
    verify(message, [steps, times, *_data(message.fields), *_data(message.scene_arrays), message.checkpoint.data],
           "a message of the stream", asked)


def verify_diagnosis(message: pb.DiagnoseResponse, asked: bool) -> None:
    what = f"the diagnosis of step {message.step}"
    numbers = [number for i in message.invariants for number in (i.initial, i.value, i.drift, i.scale)]
    verify(message, [np.int64(message.step).tobytes(), _floats([message.time, *numbers])], what, asked)
    verify(message, _details(message), what, asked, "details_checksum")


def verify_tradeoff(message: pb.MeasureTradeoffResponse, asked: bool) -> None:
    verify(message, _part_of_tradeoff(message), "a part of the trade-off", asked)


def verify_session(message: pb.Session, asked: bool) -> None:
    verify(message, _scene(message.scene), f"the scene of session {message.session_id}", asked)


def verify_conversion(message: pb.ConvertResponse, asked: bool) -> None:
    verify(message, [*_scene(message.scene), *_data(message.scene_arrays), *_data(message.blocks)], "the conversion",
           asked)


def verify_geodesic(message: pb.ConnectResponse, asked: bool) -> None:
    verify(message, [*_scene(message.scene), message.trajectory.value.data], f"the geodesic of pair {message.pair}",
           asked)


def _data(fields: Iterable[pb.Field]) -> Iterator[bytes]:
    return (field.value.data for field in fields)


def _scene(scene: pb.Scene) -> Iterator[bytes]:
    yield from (_floats(getattr(scene, name)) for name in _LISTS)
    yield from (_floats(getattr(scene.body, name)) for name in _BODY_LISTS)
    for name in sorted(scene.initial, key=str.encode):
        yield _floats(scene.initial[name].values)
        yield _floats(scene.initial[name].imaginary)


def _details(message: pb.DiagnoseResponse) -> Iterator[bytes]:
    """What `DiagnoseResponse.details_checksum` covers."""
    yield _counts(i.member for i in message.invariants if i.HasField("member"))
    yield from _present(message, "orthogonality")
    if message.HasField("domain"):
        yield _floats([message.domain.h_omega])
        yield from _present(message.domain, "largest_step")
    yield _floats(message.forms)
    yield _floats(message.dirac_brackets)
    yield from _present(message, "symplectic_defect")
    if message.HasField("estimated_error"):
        error = message.estimated_error
        yield from _present(error, "attitude", "momentum", "angle")
        yield _floats([error.reference_error, error.work, error.run_work])
        yield _counts([error.member] if error.HasField("member") else [])


def _part_of_tradeoff(message: pb.MeasureTradeoffResponse) -> Iterator[bytes]:
    if message.HasField("setup"):
        setup = message.setup
        yield _floats([setup.reference_error, setup.horizon])
        yield np.array([setup.steps, setup.reference_steps], "<i8").tobytes()
        yield _floats([setup.budget])
        yield _counts([setup.repeats, setup.curves])
    elif message.HasField("point"):
        point = message.point
        yield _counts(getattr(point.method, name) for name in ("order", "substeps") if point.method.HasField(name))
        yield from _present(point.method, "tolerance")
        yield from _present(point, "attitude_error", "momentum_error")
        yield _floats([point.drift, point.work, *point.cpu_seconds_per_second, point.steps_per_second])
        yield np.array(point.measured_steps, "<i8").tobytes()
    else:
        yield _counts(message.front.points)


def _present(message: Any, *names: str) -> Iterator[bytes]:
    """The optional float64 fields that the message has."""
    return (_floats([getattr(message, name)]) for name in names if message.HasField(name))


def _counts(numbers: Iterable[int]) -> bytes:
    return np.array(list(numbers), "<u4").tobytes()


def _floats(numbers: Iterable[float]) -> bytes:
    return np.array(numbers, "<f8").tobytes()
