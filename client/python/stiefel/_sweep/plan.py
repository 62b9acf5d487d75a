"""The plan of a sweep: divides its points into chunks, ensembles of about one second of work, whose sizes never depend on
the workers."""
from __future__ import annotations

import copy
import json
from dataclasses import asdict, dataclass, replace
from typing import Any, Callable, NamedTuple, Optional

import numpy as np
from numpy.typing import NDArray

from stiefel import v1 as pb
from stiefel._given.shapes import owner_of
from stiefel._sweep.axes import COMMON, Axes
from stiefel._sweep.result import sha256
from stiefel._wire.arrays import decode, put_block, to_array
from stiefel._scene import to_dict, to_method

WORK = 2.0**34  #: instructions of a chunk, about a second of one core
CREATION = 2.0**20  #: instructions for checking and setting up one member
READING = 2.0**10  #: instructions for reading one quantity of one sample, which a predicted price leaves out
LARGEST = 1 << 14  #: the most members of a chunk
KEPT = 1 << 20  #: the most numbers that the quantiles of one call may keep


@dataclass(frozen=True)
class Asked:
    """What is asked of every motion: statistics over the samples at the steps start, start + every, ... and `to`."""

    to: int
    start: int
    every: int
    summarize: dict[str, dict[str, Any]]  #: by quantity, as `Session.summarize` takes them


@dataclass(frozen=True, eq=False)
class Task:
    """Everything that a worker needs to compute a chunk. A task has the same result on every worker."""

    scene: bytes  #: the ensemble as a serialized message
    asked: Asked
    numerics_id: str = ""  #: that of the build which may compute the task; empty: any
    threads: Optional[int] = None  #: threads of the worker's own server; 0: all cores; None: those that a scheduler gave it
    #: How often the task failed before. It makes each attempt a different task: Dask would return the remembered
    #: failure.
    attempt: int = 0


class Resolved(NamedTuple):
    """What a server says of one ensemble."""

    method: dict[str, Any]  #: the resolved method; empty for a discrete system
    rank: int  #: the place of the method among those that the server recommends for the system; later ones take more scenes
    step_work: float  #: instructions for one step of one member
    kept: int  #: how many numbers the quantiles keep for one sample of one member
    numerics_id: str
    build: str


@dataclass(frozen=True, eq=False)
class Group:
    """Points that may be members of one ensemble, because they agree in the fields that members share."""

    scene: pb.Scene
    begin: int  #: the first point, as an index in `Plan.order`
    end: int  #: one past the last point


@dataclass(frozen=True, eq=False)
class Plan:
    """The points of a sweep in chunks: chunk k has the points `order[begin:end]`, with begin and end of `chunks[k]`."""

    axes: Axes
    groups: tuple[Group, ...]
    order: NDArray[np.int64]  #: all points, ordered by group and row-major within each group
    chunks: tuple[tuple[int, int, int], ...]  #: group, begin, end
    template: Task  #: all tasks are copies of it
    scene: dict[str, Any]  #: as it was given, without lists and blocks that the axes set
    build: str = ""

    def points(self, chunk: int) -> NDArray[np.int64]:
        _, begin, end = self.chunks[chunk]
        return self.order[begin:end]

    def name(self, chunk: int) -> str:
        first, last = self.points(chunk)[[0, -1]]
        return f"point {first}" if first == last else f"the chunk of points {first} to {last}"

    def task(self, chunk: int) -> Task:
        scene = ensemble(self.groups[self.chunks[chunk][0]].scene, self.axes, self.points(chunk))
        return replace(self.template, scene=scene.SerializeToString(deterministic=True))

    def methods(self) -> tuple[list[dict[str, Any]], NDArray[np.uint16]]:
        """Returns the methods of all points, and for each point the index of its method."""
        names = [json.dumps(to_dict(group.scene).get("method"), sort_keys=True) for group in self.groups]
        known = sorted(set(names))
        which = np.zeros(self.axes.points, "<u2")
        for group, name in zip(self.groups, names):
            which[self.order[group.begin:group.end]] = known.index(name)
        return [json.loads(name) for name in known], which

    def identity(self) -> dict[str, Any]:
        """Returns, part by part, everything that decides the result's bytes and the points of each chunk."""
        return {
            "scene": self.scene,
            "axes": sha256({axis.path: ((), axis.values) for axis in self.axes.axes}),
            "zipped": self.axes.zipped,
            "request": asdict(self.template.asked),
            "numerics_id": self.template.numerics_id,
            "chunks": sha256({"chunks": ((), np.array(self.chunks, "<i8"))}),
        }


def make_plan(base: pb.Scene, axes: Axes, template: Task, ask: Callable[[Plan], "list[Resolved]"]) -> Plan:
    """Makes the plan. `ask` asks workers to resolve ensembles, and raises InvalidArgument for a wrong scene. A group whose
    scene names no method gets one for all of its points; it does not depend on how the group is cut into chunks."""
    given, order = _groups(base, axes)
    parts: list[tuple[int, int, int]] = []
    for k, group in enumerate(given):
        tolerance, method = group.scene.HasField("tolerance"), group.scene.HasField("method")
        end = min(group.begin + 2, group.end) if method and not tolerance else group.end
        size = group.end - group.begin if tolerance else LARGEST  # an error is measured for the whole ensemble
        parts += [(k, begin, min(begin + size, end)) for begin in range(group.begin, end, size)]
    plan = Plan(axes, given, order, ((0, 0, 1),), template, to_dict(base))
    first, = ask(plan)
    plan = replace(plan, template=replace(template, numerics_id=first.numerics_id), build=first.build)
    answers = ask(replace(plan, chunks=tuple(parts)))
    by_group: list[list[Resolved]] = [[] for _ in given]
    for (k, _, _), answer in zip(parts, answers):
        by_group[k].append(answer)
    groups: list[Group] = []
    chunks: list[tuple[int, int, int]] = []
    for k, (group, its) in enumerate(zip(given, by_group)):
        chosen = max(its, key=lambda answer: answer.rank)
        if chosen.method and (group.scene.HasField("tolerance") or not group.scene.HasField("method")):
            scene = copy.deepcopy(group.scene)
            for name in ("tolerance", "horizon"):  # the method stands for them
                scene.ClearField(name)
            scene.method.CopyFrom(to_method(chosen.method))
            scene.method.substeps = max(answer.method.get("substeps", 0) for answer in its)
            group = replace(group, scene=scene)
        groups.append(group)
        members = members_of_a_chunk(template.asked, chosen.step_work, chosen.kept)
        chunks += [(k, begin, min(begin + members, group.end)) for begin in range(group.begin, group.end, members)]
    return replace(plan, groups=tuple(groups), chunks=tuple(chunks))


def _groups(base: pb.Scene, axes: Axes) -> tuple[tuple[Group, ...], NDArray[np.int64]]:
    """Returns the groups, and all points ordered by group and row-major within each group."""
    points = np.arange(axes.points, dtype=np.int64)
    common = [(axis, at) for axis, at in zip(axes.axes, axes.at(points)) if axis.field in COMMON]
    if not common:
        return (Group(base, 0, len(points)),), points
    _, ids = np.unique(np.stack([at for _, at in common]), axis=1, return_inverse=True)
    ids = ids.ravel()
    order = np.argsort(ids, kind="stable").astype(np.int64)
    bounds = np.flatnonzero(np.diff(ids[order], prepend=-1)).tolist() + [len(points)]
    groups = []
    for begin, end in zip(bounds, bounds[1:]):
        scene = copy.deepcopy(base)
        for axis, at in common:
            value = axis.values[at[order[begin]]]
            if axis.field == "method":
                scene.method.CopyFrom(to_method(json.loads(value)))
            else:
                owner, name = owner_of(scene, axis.field)
                setattr(owner, name, value.item())
        groups.append(Group(scene, begin, end))
    return tuple(groups), order


def members_of_a_chunk(asked: Asked, step_work: float, kept: int) -> int:
    """Returns how many members make a chunk of about `WORK` instructions whose quantiles keep at most `KEPT` numbers. A
    step of one member takes `step_work` instructions, and its quantiles keep `kept` numbers of each sample."""
    samples = -(-max(asked.to - asked.start, 0) // asked.every) + 1
    read = samples * sum(one != {"statistics": ["last"]} for one in asked.summarize.values())
    fit = int(WORK / (step_work * max(asked.to, asked.start, 1) + READING * read + CREATION))
    return max(1, min(fit, LARGEST, KEPT // (kept * samples) if kept else LARGEST))


def ensemble(base: pb.Scene, axes: Axes, points: NDArray[np.int64]) -> pb.Scene:
    """Returns the scene of the ensemble of these points. `base` has the fields that they share."""
    scene = copy.deepcopy(base)
    scene.members = members = len(points)
    for block in {*base.initial, *base.initial_tensors}:
        one = to_array(base.initial[block]) if block in base.initial else decode(base.initial_tensors[block])
        put_block(scene, block, np.broadcast_to(one, (members, *one.shape)))
    lists: dict[str, NDArray[Any]] = {}
    for axis, at in zip(axes.axes, axes.at(points)):
        values = axis.values[at]
        if axis.field.startswith("initial."):
            put_block(scene, axis.field[len("initial."):], values)
        elif axis.field not in COMMON:
            if axis.entry is not None:
                owner, name = owner_of(base, axis.field)
                whole = np.array(lists.get(axis.field, np.broadcast_to(getattr(owner, name), (members, len(getattr(owner, name))))))
                whole[:, axis.entry] = values
                values = whole
            lists[axis.field] = values
    for path, values in lists.items():
        owner, name = owner_of(scene, path)
        owner.ClearField(name)
        getattr(owner, name).extend(values.ravel().tolist())
    return scene
