"""The plan of a sweep: its points cut into chunks, each a task of its own content."""
from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass, replace
from typing import Any, Callable, Optional, Sequence

import numpy as np
from google.protobuf import json_format
from numpy.typing import NDArray

from stiefel import v1 as pb
from stiefel.errors import InvalidArgument, Violation
from stiefel.scenes import to_dict
from stiefel.sweeps.axes import Axes, set_common
from stiefel.sweeps.chunks import LARGEST, SLOWEST, WORK, Task, Values, members_of_a_chunk
from stiefel.sweeps.resolution import Question, Resolved

Ask = Callable[[Question], list[Resolved]]


@dataclass(frozen=True, eq=False)
class Group:
    """Points that may be members of one ensemble: all that is common to members is the same."""

    scene: pb.Scene
    begin: int  #: in the order of the plan
    end: int


@dataclass(frozen=True, eq=False)
class Plan:
    """Chunk k has the points `order[begin:end]` of `chunks[k]`."""

    axes: Axes
    groups: tuple[Group, ...]
    order: NDArray[np.int64]  #: points by group; row-major within each
    chunks: tuple[tuple[int, int, int], ...]  #: group, begin, end
    request: pb.SummarizeRequest
    numerics_id: str
    build: str
    scene: dict[str, Any]  #: the resolved base scene, without what the axes set
    template: Task  #: of which each task is a copy
    warnings: tuple[str, ...]

    def points(self, chunk: int) -> NDArray[np.int64]:
        _, begin, end = self.chunks[chunk]
        return self.order[begin:end]

    def task(self, chunk: int) -> Task:
        group, begin, end = self.chunks[chunk]
        return _task(self.template, self.axes, self.groups[group].scene, self.order[begin:end], chunk)

    def identity(self) -> dict[str, Any]:
        """What decides the result's bytes, and where a store has which point; by parts, for comparison."""
        return {
            "scene": json.dumps(self.scene, sort_keys=True),
            "axes": {axis.path: _digest(axis.values) for axis in self.axes.axes},
            "zipped": self.axes.zipped,
            "request": json.dumps(json_format.MessageToDict(self.request, preserving_proto_field_name=True), sort_keys=True),
            "numerics_id": self.numerics_id,
            "chunks": _digest(np.array(self.chunks, "<i8")),
        }


def make_plan(base: pb.Scene, axes: Axes, request: pb.SummarizeRequest, ask: Ask, threads: Optional[int],
              home: tuple[str, int]) -> Plan:
    """`ask` resolves ensembles; InvalidArgument from there names what is wrong with the scene."""
    template = Task(b"", 0, (), request.SerializeToString(deterministic=True), "", threads=threads, home=home)
    groups, order = _groups(base, axes)
    first = [_task(template, axes, group.scene, order[group.begin:group.begin + 1], 0) for group in groups]
    resolved = ask(Question(tuple(first)))
    template = replace(template, numerics_id=resolved[0].numerics_id)
    groups = [_with_method(group, one, template, axes, order, ask) for group, one in zip(groups, resolved)]
    steps = max(request.to, getattr(request, "from"))
    samples = -(-max(request.to - getattr(request, "from"), 0) // request.every) + 1
    chunks: list[tuple[int, int, int]] = []
    for k, (group, one) in enumerate(zip(groups, resolved)):
        members = members_of_a_chunk(one.step_work, steps, samples * len(request.quantities), one.kept * samples)
        slowest = SLOWEST * members * steps * one.step_work / WORK
        template = replace(template, timeout=max(template.timeout, slowest))
        chunks += [(k, begin, min(begin + members, group.end)) for begin in range(group.begin, group.end, members)]
    plan = Plan(axes, tuple(groups), order, tuple(chunks), request, resolved[0].numerics_id, resolved[0].build,
                _described(groups), template, tuple(dict.fromkeys(text for one in resolved for text in one.warnings)))
    _check_shapes(plan, ask)
    return plan


def _groups(base: pb.Scene, axes: Axes) -> tuple[list[Group], NDArray[np.int64]]:
    points = np.arange(axes.points, dtype=np.int64)
    common = [(axis, at) for axis, at in zip(axes.axes, axes.at(points)) if axis.common]
    if not common:
        return [Group(base, 0, len(points))], points
    _, ids = np.unique(np.stack([at for _, at in common]), axis=1, return_inverse=True)
    ids = ids.ravel()
    order = np.argsort(ids, kind="stable").astype(np.int64)
    bounds = np.flatnonzero(np.diff(ids[order], prepend=-1)).tolist() + [len(points)]
    groups = []
    for begin, end in zip(bounds, bounds[1:]):
        scene = pb.Scene()
        scene.CopyFrom(base)
        for axis, at in common:
            set_common(scene, axis.field, axis.values[at[order[begin]]])
        groups.append(Group(scene, begin, end))
    return groups, order


def _task(template: Task, axes: Axes, scene: pb.Scene, points: NDArray[np.int64], index: int) -> Task:
    values = tuple(Values(axis.field, axis.entry, axis.values[at]) for axis, at in zip(axes.axes, axes.at(points))
                   if not axis.common)
    return replace(template, scene=scene.SerializeToString(deterministic=True), members=len(points), values=values,
                   index=index)


def _with_method(group: Group, first: Resolved, template: Task, axes: Axes, order: NDArray[np.int64], ask: Ask) -> Group:
    """The group with its method written out, so that it does not depend on the cut into chunks.

    A recommended method has as many substeps as the most demanding point needs. One for a tolerance is chosen on the
    first point.
    """
    if not first.method or group.scene.HasField("method"):
        return group
    scene = pb.Scene()
    scene.CopyFrom(group.scene)
    scene.method.ParseFromString(first.method)
    if scene.HasField("tolerance"):
        scene.ClearField("tolerance")
        scene.ClearField("horizon")
        return replace(group, scene=scene)
    for begin in range(group.begin, group.end, LARGEST):
        part = _task(template, axes, group.scene, order[begin:min(begin + LARGEST, group.end)], 0)
        method = pb.Method.FromString(ask(Question((part,)))[0].method)
        scene.method.substeps = max(scene.method.substeps, method.substeps)
    return replace(group, scene=scene)


def _check_shapes(plan: Plan, ask: Ask) -> None:
    """The first chunk of each group as a whole, but its members few: an ensemble may need what one motion does not."""
    tasks = []
    for k, group in enumerate(plan.groups):
        if group.end - group.begin > 1:
            tasks.append(_task(plan.template, plan.axes, group.scene, plan.order[group.begin:min(group.begin + 2, group.end)], k))
    if tasks:
        ask(Question(tuple(tasks)))


def _described(groups: Sequence[Group]) -> dict[str, Any]:
    """The scene of the groups, less what differs among them."""
    scene = to_dict(groups[0].scene)
    for group in groups[1:]:
        other = to_dict(group.scene)
        scene = {name: value for name, value in scene.items() if other.get(name) == value}
    return scene


def _digest(values: NDArray[Any]) -> str:
    head = f"{values.dtype.str} {values.shape}\n".encode()
    return hashlib.sha256(head + np.ascontiguousarray(values).tobytes()).hexdigest()


def place_violations(error: InvalidArgument, plan: Plan, chunk: int) -> InvalidArgument:
    """The error of a chunk with the point of the sweep where its first member stands."""
    points = plan.points(chunk)
    where = f"in the chunk of points {points[0]} to {points[-1]}"
    return InvalidArgument(f"{error.message} ({where})", tuple(Violation(v.field, f"{v.description} ({where})")
                                                              for v in error.violations), error.reason)
