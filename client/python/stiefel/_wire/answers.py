"""Reads the messages of whole answers."""
from __future__ import annotations

from functools import partial
from typing import Any, Mapping, Optional, Sequence, TypeVar

import numpy as np
from google.protobuf import json_format

from stiefel import v1 as pb
from stiefel._given.shapes import is_repeated
from stiefel._manifold.beta import Span
from stiefel._results.base import Array
from stiefel._results.motion import KINDS, motion_of
from stiefel._wire.arrays import blocks_of, decode, decode_fields, named, put_block, to_array
from stiefel._wire.replies import ends_at, name_of, optional, require, run_status
from stiefel.results import (Choice, ConjugatePoint, ConjugatePoints, Conservation, Conversion, Diagnosis, Domain, EstimatedError, EstimatedErrors, Events, Geodesic, Invariant,
                             Outcome, Point, RunStatus, State, Summary, Tradeoff)
from stiefel._scene import to_dict

T = TypeVar("T")


def read(kind: type[T], message: Any, **given: Any) -> T:
    """Returns a `kind`, a dataclass, with the fields of `message` of the same names and those `given`. A list becomes a
    tuple, an absent field None."""
    for name, field in ((field.name, field) for field in message.DESCRIPTOR.fields):
        if name not in given and name in kind.__dataclass_fields__:  # type: ignore[attr-defined]
            value = getattr(message, name)
            given[name] = tuple(value) if is_repeated(field) else optional(message, name) if field.has_presence else value
    return kind(**given)


def state(message: pb.StepResponse, fields: dict[str, Array]) -> State:
    """`fields`: those of the message's sample."""
    sample = message.sample
    return State(sample.step, sample.time, fields, run_status(message.run_status), message.computed_steps,
                 message.checkpoint, message.work)


def choice(message: Any) -> Optional[Choice]:
    """Reads the choice in the message of a session or a conversion; None if its scene had no tolerance."""
    if not message.HasField("choice"):
        return None
    method = json_format.MessageToDict(message.choice.method, preserving_proto_field_name=True)
    return read(Choice, message.choice, method=method)


def conversion(message: pb.ConvertResponse) -> Conversion:
    blocks = decode_fields(message.blocks)
    scene = to_dict(message.scene) if message.HasField("scene") else None
    require(bool(blocks) == (scene is None), "a conversion has a scene or blocks")
    return Conversion(scene, named(blocks), {margin.domain: margin.margin for margin in message.margins}, choice(message))


def _scene(scene: pb.Scene, span: Optional[Span] = None, pair: int = 0) -> dict[str, Any]:
    """Returns a scene. `span`: that in whose basis of a pair its frames are."""
    if span is not None:
        scene.inertia[:] = [scene.inertia[0]] * span.Q.shape[-1]
        for name, block in blocks_of(scene).items():
            put_block(scene, name, span.lifted(pair, block))
    return to_dict(scene)


def geodesic(message: pb.ConnectResponse, request: pb.ConnectRequest, span: Optional[Span]) -> Geodesic:
    """`span`: that in whose bases the frames of the request are."""
    status, scene, shortest = run_status(message.run_status), None, "unspecified"
    velocity, trajectory = (decode(getattr(message, name).value) if message.HasField(name) else None
                            for name in ("velocity", "trajectory"))
    if status.outcome == Outcome.REACHED:
        shortest = name_of(pb.Shortest, message.shortest).lower()
        first = request.pairs[message.pair].q_0
        n, N = first.rows, first.cols
        steps = request.steps or request.samples
        for array, shape in ((velocity, None if request.steps else (n, N)), (trajectory, (steps + 1, n, N) if steps else None)):
            require((array if array is None else (array.dtype, array.shape)) == (shape and (np.dtype(np.float64), shape)),
                    "velocity or trajectory are not those that were asked for")
        if message.HasField("scene"):
            scene = partial(_scene, message.scene, span, message.pair)
    if span is not None:
        velocity, trajectory = (array if array is None else span.lifted(message.pair, array) for array in (velocity, trajectory))
    return read(Geodesic, message, _scene=scene, velocity=velocity, shortest=shortest, trajectory=trajectory, run_status=status)


def conjugate_points(message: pb.ConjugatePointsResponse, request: pb.ConjugatePointsRequest) -> ConjugatePoints:
    points = []
    for point in message.points:
        kernel = np.array([to_array(one) for one in point.kernel])
        require(kernel.shape == (point.multiplicity, request.q.rows, request.q.cols), f"a kernel has the shape {kernel.shape}")
        points.append(read(ConjugatePoint, point, kernel=kernel))
    return read(ConjugatePoints, message, points=tuple(points), run_status=run_status(message.run_status))


def diagnosis(message: pb.DiagnoseResponse, request: pb.DiagnoseRequest, in_si: bool = False) -> Diagnosis:
    """`in_si`: whether the scene has `body`."""
    for given, asked in ((message.forms, request.forms), (message.dirac_brackets, request.dirac_brackets)):
        require(len(given) == len(asked), f"{len(given)} values for {len(asked)} forms or brackets")
    ends_at(message.run_status, message.step, request.to)
    invariants = tuple(read(Invariant, one, conservation=Conservation(one.conservation)) for one in message.invariants)
    error = read(EstimatedError, message.estimated_error) if message.HasField("estimated_error") else None
    motion = message.motion if message.HasField("motion") else None
    require(motion is None or motion.kind in KINDS, "the motion of a body has another kind")
    return read(Diagnosis, message, invariants=invariants, domain=read(Domain, message.domain), estimated_error=error,
                run_status=run_status(message.run_status),
                shortened={family.name: family.count for family in message.shortened},
                motion=None if motion is None else motion_of(motion, in_si))


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
                tolerance=optional(method, "tolerance"), arithmetic=method.arithmetic, scalar=method.scalar or "double",
                run_status=run_status(message.run_status))


def events(batch: pb.EventBatch, fields: dict[str, Array], ensemble: bool) -> Events:
    return Events(np.array(batch.events, np.uint32), np.array(batch.steps, np.int64), np.array(batch.fractions),
                  np.array(batch.times), np.array(batch.members, np.uint32) if ensemble else None, fields)


def errors(times: Array, steps: Array, found: Sequence[Optional[EstimatedError]]) -> EstimatedErrors:
    def numbers(name: str) -> Array:
        return np.array([getattr(one, name, None) for one in found], float)  # None becomes NaN

    reference = next((one.reference for one in found if one and one.reference), "")
    missing = next((one.missing for one in found if one and one.missing), "")
    return EstimatedErrors(times, steps, numbers("attitude"), numbers("momentum"), numbers("angle"), numbers("reference_error"),
                  reference, missing)


def no_events(fields: Mapping[str, Array], ensemble: bool) -> Events:
    """`fields`: the fields of some state, which give names, shapes and types."""
    empty = {name: np.empty((0, *values.shape[ensemble:]), values.dtype) for name, values in fields.items()}
    return events(pb.EventBatch(), empty, ensemble)


def joined(parts: Sequence[Events], run_status: RunStatus) -> Events:
    """Returns the events of all parts, of which there must be one or more."""
    def join(name: str) -> Any:
        return np.concatenate([getattr(part, name) for part in parts])

    return Events(join("event"), join("step"), join("fraction"), join("time"),
                  None if parts[0].member is None else join("member"),
                  {name: np.concatenate([part.fields[name] for part in parts]) for name in parts[0].fields}, run_status)


_OUTCOMES = np.array([name[len("OUTCOME_"):] for name in pb.Outcome.keys()])


def check_statistics(arrays: Mapping[str, Array], request: pb.SummarizeRequest, ensemble: bool) -> None:
    """Raises CorruptReply unless `arrays` have each quantity that the request asks for, and how each motion ended."""
    wanted = {"outcome", "last_step", "ended_by", "samples", *(quantity.name for quantity in request.quantities)}
    found = {name.rpartition(".")[0] or name for name in arrays}
    require(found == wanted, f"it has the statistics {', '.join(arrays)}")
    outcome = arrays["outcome"]
    require(outcome.ndim == ensemble and outcome.shape == arrays["last_step"].shape and set(outcome.flat) <= set(range(1, len(_OUTCOMES))),
            f"the outcomes are {outcome}")


def summary(arrays: Mapping[str, Array], run_status: RunStatus, computed_steps: int, work: float,
            checkpoint: bytes) -> Summary:
    """Reads statistics, "quaternion.last" and others. Their arrays get the axes of the field that the caller gets."""
    quantities: dict[str, dict[str, Array]] = {}
    for name, array in arrays.items():
        quantity, dot, statistic = name.rpartition(".")
        if dot:
            behind = int(statistic in ("quantiles", "histogram"))
            quantities.setdefault(quantity, {})[statistic] = named({quantity: array}, behind)[quantity]
    return Summary(quantities, _OUTCOMES[arrays["outcome"]], arrays["last_step"], arrays["ended_by"],
                   arrays["samples"], run_status, computed_steps, work, checkpoint)
