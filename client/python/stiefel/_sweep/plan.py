"""The plan of a sweep: divides its points into chunks, each of which is a task for a worker."""
from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass, replace
from typing import Any, Optional, Sequence

import numpy as np
from google.protobuf import json_format
from numpy.typing import NDArray

from stiefel import v1 as pb
from stiefel.errors import InvalidArgument
from stiefel.scene import to_dict
from stiefel._sweep.axes import Axes
from stiefel._sweep.choices import AskAll, ask, by_choice, with_recommended
from stiefel._sweep.chunks import SLOWEST, WORK, Task, members_of_a_chunk
from stiefel._sweep.failures import at
from stiefel._sweep.fold import per_member
from stiefel._sweep.groups import Group, groups_of, task_of
from stiefel._sweep.resolution import Question


@dataclass(frozen=True, eq=False)
class Plan:
    """The points of a sweep in chunks: chunk k has the points `order[begin:end]`, with begin and end of `chunks[k]`."""

    axes: Axes
    groups: tuple[Group, ...]
    order: NDArray[np.int64]  #: all points, ordered by group and row-major within each group
    chunks: tuple[tuple[int, int, int], ...]  #: group, begin, end
    request: pb.SummarizeRequest
    numerics_id: str
    build: str
    scene: dict[str, Any]  #: the resolved base scene, without fields that the axes set and without methods that differ
    fills_in: bool  #: whether the server filled in methods that may differ between points
    template: Task  #: all tasks are copies of it
    warnings: tuple[str, ...]

    def points(self, chunk: int) -> NDArray[np.int64]:
        _, begin, end = self.chunks[chunk]
        return self.order[begin:end]

    def task(self, chunk: int) -> Task:
        group, begin, end = self.chunks[chunk]
        return task_of(self.template, self.axes, self.groups[group].scene, self.order[begin:end], chunk)

    def methods(self) -> tuple[list[dict[str, Any]], NDArray[np.uint16]]:
        """Returns the methods of all points, and for each point the index of its method."""
        known = sorted({group.scene.method.SerializeToString(deterministic=True) for group in self.groups})
        which = np.zeros(self.axes.points, "<u2")
        for group in self.groups:
            which[self.order[group.begin:group.end]] = known.index(group.scene.method.SerializeToString(deterministic=True))
        return [to_dict(pb.Scene(method=pb.Method.FromString(name)))["method"] for name in known], which

    def identity(self) -> dict[str, Any]:
        """Returns, part by part, everything that decides the result's bytes and the place of each point in a store."""
        return {
            "scene": json.dumps(self.scene, sort_keys=True),
            "axes": {axis.path: _digest(axis.values) for axis in self.axes.axes},
            "zipped": self.axes.zipped,
            "request": json.dumps(json_format.MessageToDict(self.request, preserving_proto_field_name=True), sort_keys=True),
            "numerics_id": self.numerics_id,
            "chunks": _digest(np.array(self.chunks, "<i8")),
        }


def make_plan(base: pb.Scene, axes: Axes, request: pb.SummarizeRequest, ask_all: AskAll, threads: Optional[int],
              home: tuple[str, int]) -> Plan:
    """Makes the plan. `ask_all` asks workers to resolve ensembles, and raises InvalidArgument for a wrong scene."""
    template = Task(b"", 0, (), per_member(request).SerializeToString(deterministic=True), "", threads=threads, home=home)
    given, order = groups_of(base, axes)
    first = ask(Question(tuple(task_of(template, axes, group.scene, order[group.begin:group.begin + 1], 0) for group in given)),
                ask_all)
    template = replace(template, numerics_id=first[0].numerics_id)
    parts = []
    for group, one in zip(given, first):
        parts += by_choice(group, template, axes, order, ask_all) if group.scene.HasField("tolerance") else [
            with_recommended(group, one, template, axes, order, ask_all)]
    groups, resolved = tuple(group for group, _ in parts), [one for _, one in parts]
    steps = max(request.to, getattr(request, "from"))
    samples = -(-max(request.to - getattr(request, "from"), 0) // request.every) + 1
    read = sum(_is_read_on_the_way(quantity) for quantity in request.quantities)
    chunks: list[tuple[int, int, int]] = []
    for k, (group, one) in enumerate(zip(groups, resolved)):
        members = members_of_a_chunk(one.step_work, steps, samples * read, one.kept * samples)
        slowest = SLOWEST * members * steps * one.step_work / WORK
        template = replace(template, timeout=max(template.timeout, slowest))
        chunks += [(k, begin, min(begin + members, group.end)) for begin in range(group.begin, group.end, members)]
    plan = Plan(axes, groups, order, tuple(chunks), request, first[0].numerics_id, first[0].build,
                _described(groups, given), _fills_in(groups, given), template,
                tuple(dict.fromkeys(text for one in resolved for text in one.warnings)))
    _check_shapes(plan, ask_all)
    return plan


def _fills_in(groups: Sequence[Group], given: Sequence[Group]) -> bool:
    """Returns whether methods were chosen for a tolerance, or are those recommended for scenes that differ in `step` or
    another field that members share."""
    chosen = any(group.scene.HasField("tolerance") for group in given)
    named = all(group.scene.HasField("method") for group in given)
    has_method = any(group.scene.HasField("method") for group in groups)  # a discrete system has none
    return chosen or (len(groups) > 1 and has_method and not named)


def _is_read_on_the_way(quantity: pb.Quantity) -> bool:
    """Returns whether the quantity asks for more than its last value, so that it is read at every sample."""
    return bool(set(quantity.statistics) - {pb.STATISTIC_LAST} or quantity.quantiles or quantity.edges)


def _check_shapes(plan: Plan, ask_all: AskAll) -> None:
    """Resolves the first two members of each group as an ensemble, because an ensemble may be refused where a single
    motion is not."""
    tasks = []
    for k, group in enumerate(plan.groups):
        if group.end - group.begin > 1:
            tasks.append(task_of(plan.template, plan.axes, group.scene, plan.order[group.begin:min(group.begin + 2, group.end)], k))
    if tasks:
        ask(Question(tuple(tasks)), ask_all)


def _described(groups: Sequence[Group], given: Sequence[Group]) -> dict[str, Any]:
    """Returns the scene of the groups without the fields in which they differ. If these include methods chosen for a
    tolerance, the scene has the tolerance instead."""
    scene, asked = _common(groups), _common(given)
    if "method" not in scene and "tolerance" in asked:
        scene = asked
    return scene


def _common(groups: Sequence[Group]) -> dict[str, Any]:
    scene = to_dict(groups[0].scene)
    for group in groups[1:]:
        other = to_dict(group.scene)
        scene = {name: value for name, value in scene.items() if other.get(name) == value}
    return scene


def _digest(values: NDArray[Any]) -> str:
    head = f"{values.dtype.str} {values.shape}\n".encode()
    return hashlib.sha256(head + np.ascontiguousarray(values).tobytes()).hexdigest()


def place_violations(error: InvalidArgument, plan: Plan, chunk: int) -> InvalidArgument:
    """Returns the error of a chunk with the chunk's points added."""
    points = plan.points(chunk)
    return at(error, f"in the chunk of points {points[0]} to {points[-1]}")
