"""Groups the points of a sweep that may belong to one ensemble."""
from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stiefel import v1 as pb
from stiefel._sweep.axes import Axes, set_common
from stiefel._sweep.chunks import Task, Values


@dataclass(frozen=True, eq=False)
class Group:
    """Points that may be members of one ensemble, because they agree in the fields that members share."""

    scene: pb.Scene
    begin: int  #: the first point, as an index in `Plan.order`
    end: int  #: one past the last point


def groups_of(base: pb.Scene, axes: Axes) -> tuple[list[Group], NDArray[np.int64]]:
    """Returns the groups, and all points ordered by group and row-major within each group."""
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


def task_of(template: Task, axes: Axes, scene: pb.Scene, points: NDArray[np.int64], index: int) -> Task:
    """Returns a copy of `template` for the ensemble of these points."""
    values = tuple(Values(axis.field, axis.entry, axis.values[at]) for axis, at in zip(axes.axes, axes.at(points))
                   if not axis.common)
    return replace(template, scene=scene.SerializeToString(deterministic=True), members=len(points), values=values,
                   index=index)
