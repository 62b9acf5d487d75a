"""Reads the messages of answers, and checks what the protocol promises: the shapes of arrays, the steps, and how a run ended. A
message that is absent has enums of the value 0, which no reply has. What breaks the protocol raises CorruptReply."""
from __future__ import annotations

from functools import partial
from typing import Any, Iterable, Optional, Sequence, TypeVar

import numpy as np
from google.protobuf import json_format
from google.protobuf.message import Message

from stiefel import v1 as pb
from stiefel._given.shapes import is_repeated
from stiefel._manifold.beta import Span
from stiefel._results.base import Array
from stiefel._results.motion import KINDS, motion_of
from stiefel._wire.arrays import blocks_of, decode, decode_fields, named, put_block, require, to_array
from stiefel.results import (Choice, ConjugatePoint, ConjugatePoints, Conservation, Conversion, Diagnosis, Domain, EstimatedError,
                             Geodesic, Invariant, Outcome, Point, RunStatus, Tradeoff)
from stiefel._scene import to_dict

T = TypeVar("T")


def read(kind: type[T], message: Any, **given: Any) -> T:
    """Returns a `kind`, a dataclass, with the fields of `message` of the same names and those `given`. A list becomes a
    tuple, an absent field None."""
    for field in message.DESCRIPTOR.fields:
        if field.name not in given and field.name in kind.__dataclass_fields__:  # type: ignore[attr-defined]
            value = getattr(message, field.name)
            given[field.name] = (tuple(value) if is_repeated(field) else run_status(value) if isinstance(value, pb.RunStatus) else
                                 optional(message, field.name) if field.has_presence else value)
    return kind(**given)


def optional(message: Message, name: str) -> Any:
    """Returns the message's field; None if it is absent."""
    return getattr(message, name) if message.HasField(name) else None


def name_of(kind: Any, value: int) -> str:
    """Returns the name of an enum's value without its prefix, which is the name of the value 0 without UNSPECIFIED: "REACHED"
    for OUTCOME_REACHED. Raises CorruptReply for the value 0 and for an unknown one."""
    require(value != 0 and value in kind.values(), f"{kind.DESCRIPTOR.name} {value}")
    return str(kind.Name(value))[len(kind.Name(0)) - len("UNSPECIFIED"):]


def run_status(message: pb.RunStatus) -> RunStatus:
    return read(RunStatus, message, outcome=Outcome(name_of(pb.Outcome, message.outcome)))


def ends_at(status: RunStatus, step: int, to: int) -> None:
    """Checks that a run to step `to` that ended at `step` was at `to` exactly if it REACHED it."""
    require(step == to if status.outcome is Outcome.REACHED else 0 <= step < to, f"{status.outcome} at step {step} of {to}")


class Layout:
    """The names, types and shapes of the fields that arrive batch by batch: every batch has those of the first."""

    def __init__(self, wanted: Iterable[str] = ()):
        """`wanted`: the names that were asked for; if empty, the server decides on the fields."""
        self._wanted, self._first = set(wanted), dict[str, Any]()

    def read(self, fields: Iterable[pb.Field], count: Optional[int] = None) -> dict[str, Array]:
        """Returns the fields as the caller gets them. `count`: the elements of the batch, along the first axis; None where the
        arrays are a single element."""
        arrays, batch = decode_fields(fields), count is not None
        found = {name: (array.dtype, array.shape[batch:]) for name, array in arrays.items()}
        require(found.keys() == (self._wanted or found.keys()) and len(found) > 0, f"it has the fields {', '.join(found)}")
        self._first = self._first or found
        require(found == self._first and all(array.ndim >= 2 + batch and array.dtype.kind in "fc" and (not batch or len(array) == count)
                                             for array in arrays.values()), "its fields have other names, types or shapes")
        return named(arrays)


def described(session: pb.Session, id: str, whole: bool = True) -> pb.Session:
    """Returns the description of the session `id`. `whole`: whether it must have the scene."""
    require(session.session_id == id, f"the session is {session.session_id!r}, not {id}")
    require(session.HasField("scene") and session.scene.system == session.system or not whole,
            f"the session has no scene of {session.system!r}")
    return session


def choice(message: Any) -> Optional[Choice]:
    """Reads the choice in the message of a session or a conversion; None if its scene had no tolerance."""
    method = json_format.MessageToDict(message.choice.method, preserving_proto_field_name=True)
    return read(Choice, message.choice, method=method) if message.HasField("choice") else None


def conversion(message: pb.ConvertResponse) -> Conversion:
    blocks, scene = named(decode_fields(message.blocks)), to_dict(message.scene) if message.HasField("scene") else None
    require(bool(blocks) == (scene is None), "a conversion has a scene or blocks")
    return Conversion(scene, blocks, {margin.domain: margin.margin for margin in message.margins}, choice(message))


def _scene(scene: pb.Scene, span: Optional[Span] = None, pair: int = 0) -> dict[str, Any]:
    """Returns a scene. `span`: that in whose basis of a pair its frames are."""
    if span is not None:
        scene.inertia[:] = [scene.inertia[0]] * span.Q.shape[-1]
        for name, block in blocks_of(scene).items():
            put_block(scene, name, span.lifted(pair, block))
    return to_dict(scene)


def geodesic(message: pb.ConnectResponse, request: pb.ConnectRequest, span: Optional[Span]) -> Geodesic:
    """`span`: that in whose bases the frames of the request are."""
    scene, shortest = None, "unspecified"
    velocity, trajectory = (decode(getattr(message, name).value) if message.HasField(name) else None
                            for name in ("velocity", "trajectory"))
    if message.run_status.outcome == pb.OUTCOME_REACHED:
        shortest = name_of(pb.Shortest, message.shortest).lower()
        first, steps = request.pairs[message.pair].q_0, request.steps or request.samples
        for array, asked, shape in ((velocity, not request.steps, (first.rows, first.cols)),
                                    (trajectory, steps, (steps + 1, first.rows, first.cols))):
            require((array is not None and array.dtype == np.float64 and array.shape == shape) if asked else array is None,
                    "velocity or trajectory are not those that were asked for")
        if message.HasField("scene"):
            scene = partial(_scene, message.scene, span, message.pair)
    if span is not None:
        velocity, trajectory = (array if array is None else span.lifted(message.pair, array) for array in (velocity, trajectory))
    return read(Geodesic, message, _scene=scene, velocity=velocity, shortest=shortest, trajectory=trajectory)


def conjugate_points(message: pb.ConjugatePointsResponse, request: pb.ConjugatePointsRequest) -> ConjugatePoints:
    points = []
    for point in message.points:
        kernel = np.array([to_array(one) for one in point.kernel])
        require(kernel.shape == (point.multiplicity, request.q.rows, request.q.cols), f"a kernel has the shape {kernel.shape}")
        points.append(read(ConjugatePoint, point, kernel=kernel))
    return read(ConjugatePoints, message, points=tuple(points))


def diagnosis(message: pb.DiagnoseResponse, request: pb.DiagnoseRequest, in_si: bool = False) -> Diagnosis:
    """`in_si`: whether the scene has `body`."""
    for given, asked in ((message.forms, request.forms), (message.dirac_brackets, request.dirac_brackets)):
        require(len(given) == len(asked), f"{len(given)} values for {len(asked)} forms or brackets")
    ends_at(run_status(message.run_status), message.step, request.to)
    error, motion = optional(message, "estimated_error"), optional(message, "motion")
    require(motion is None or motion.kind in KINDS, "the motion of a body has another kind")
    invariants = tuple(read(Invariant, one, conservation=Conservation(one.conservation)) for one in message.invariants)
    return read(Diagnosis, message, invariants=invariants, domain=read(Domain, message.domain),
                estimated_error=error and read(EstimatedError, error),
                shortened={family.name: family.count for family in message.shortened}, motion=motion and motion_of(motion, in_si))


def tradeoff(parts: Sequence[pb.MeasureTradeoffResponse]) -> Tradeoff:
    """Reads the setup, the points and the front."""
    kinds = [part.WhichOneof("part") for part in parts]
    require(kinds == ["setup", *["point"] * (len(kinds) - 2), "front"], f"its parts are {kinds}")
    points, front = tuple(_point(part.point) for part in parts[1:-1]), parts[-1].front.points
    require(all(i < len(points) for i in front), f"the front is not of {len(points)} points")
    return read(Tradeoff, parts[0].setup, points=points, front=tuple(points[i] for i in front))


def _point(message: pb.TradeoffPoint) -> Point:
    method = message.method
    return read(Point, message, method=method.name, order=method.order, substeps=method.substeps,
                tolerance=optional(method, "tolerance"), arithmetic=method.arithmetic, scalar=method.scalar or "double")
