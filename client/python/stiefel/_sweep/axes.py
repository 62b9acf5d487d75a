"""Axes of a sweep: values for fields of a scene, as a grid or side by side."""
from __future__ import annotations

import copy
import itertools
import json
import re
from dataclasses import dataclass
from typing import Any, Mapping, Optional

import numpy as np
from google.protobuf.descriptor import FieldDescriptor
from numpy.typing import NDArray

from stiefel import v1 as pb
from stiefel._given.numbers import numbers, refused
from stiefel._given.shapes import FIELDS, LISTS, NUMBERS, TENSOR, count_of, described, of_symmetric, owner_of
from stiefel._given.shown import shown
from stiefel.errors import InvalidArgument
from stiefel._scene import to_dict, to_message, to_method

#: Fields that all members of an ensemble share. Points that differ in one of them belong to different ensembles.
COMMON = (*(path for path in NUMBERS if "." not in path), "method", *(path for path in FIELDS if path.startswith("method.")))
POINT = "point"  #: the name of the dimension of axes side by side
_ENTRY = re.compile(r"(.+)\[(\d+)\]")


@dataclass(frozen=True, eq=False)
class Axis:
    """The values along one axis."""

    path: str
    field: str  #: the path without an index
    entry: Optional[int]  #: the index of the one number of a list that varies; None for the whole field
    values: NDArray[Any]  #: for a list (points, numbers), for a block (points, rows, cols), else (points,)


@dataclass(frozen=True, eq=False)
class Axes:
    """All axes of a sweep. A grid has a dimension for each axis; axes side by side have the one dimension `POINT`."""

    axes: tuple[Axis, ...]
    zipped: bool

    @property
    def shape(self) -> tuple[int, ...]:
        sizes = tuple(len(axis.values) for axis in self.axes)
        return sizes[:1] if self.zipped else sizes

    @property
    def dims(self) -> tuple[str, ...]:
        """The names of the dimensions. The dimension of an axis of single numbers or names has the axis's path as its
        name. That of an axis of lists or blocks is PATH_point, because xarray needs an index of one dimension."""
        if self.zipped:
            return (POINT,)
        return tuple(axis.path if axis.values.ndim == 1 else f"{axis.path}_{POINT}" for axis in self.axes)

    @property
    def points(self) -> int:
        return int(np.prod(self.shape, dtype=np.int64))

    def at(self, points: NDArray[np.int64]) -> list[NDArray[np.int64]]:
        """Returns, for each axis, the indices along it of points that are counted in row-major order."""
        if self.zipped:
            return [points] * len(self.axes)
        return list(np.unravel_index(points, self.shape))


def read_axes(axes: Mapping[str, Any], zipped: bool) -> Axes:
    """Checks paths and shapes and returns the axes. Raises InvalidArgument that names the first wrong axis."""
    if not isinstance(axes, Mapping) or not axes:
        raise refused("axes", f"{shown(axes)}: must be a mapping from paths into the scene to values")
    read = tuple(_axis(path, values) for path, values in axes.items())
    sizes = {axis.path: len(axis.values) for axis in read}
    if zipped and len(set(sizes.values())) > 1:
        raise refused("axes", f"{sizes}: must have as many values each, because they stand side by side")
    for one, other in itertools.permutations(read, 2):
        same = other.field == one.field and (one.entry == other.entry or None in (one.entry, other.entry))
        if same or one.field == "method" and other.field.startswith("method."):
            raise refused(f"axes[{one.path!r}]", f"{other.path} is an axis too: must be different numbers")
    return Axes(read, zipped)


def _axis(path: Any, values: Any) -> Axis:
    place = f"axes[{path!r}]"
    if not isinstance(path, str):
        raise refused(place, "must be a path into the scene")
    found = _ENTRY.fullmatch(path)
    field = found[1] if found else path
    entry = int(found[2]) if found else None
    rank = 3 if field.startswith("initial.") and field != "initial." else 2 if field in LISTS else int(field in COMMON)
    if rank == 0 or entry is not None and rank != 2:
        known = ", ".join((*LISTS, "initial.BLOCK", *COMMON))
        raise refused(place, f"{path}: must be a field that a sweep varies, or one number of a list: {known}")
    rank = 1 if found else rank
    array = _values(field, values, place)
    if field.startswith("initial.") and rank == 3 and array.ndim == 2:
        array = array[:, np.newaxis, :]  # a block of one row
    if field == TENSOR and rank == 2 and array.ndim == 3 and array.shape[1:] == (3, 3):
        array = of_symmetric(place, array)
    each = count_of(field)
    shape = {1: "(points)", 2: f"(points, {each or 'dimension'})", 3: "(points, rows, cols)"}[rank]
    if array.ndim != rank or 0 in array.shape or (rank == 2 and each not in (None, array.shape[1])):
        raise refused(place, f"the shape {array.shape}: must be {shape}")
    return Axis(path, field, entry, array)


def _values(field: str, values: Any, place: str) -> NDArray[Any]:
    """Returns the values in the little-endian type in which they travel."""
    kind = FIELDS[field].cpp_type if field in FIELDS else None  # a block has none
    if field == "method":
        return _methods(values, place)
    if kind == FieldDescriptor.CPPTYPE_STRING:
        array = np.asarray(values) if np.ndim(values) == 1 else np.empty(0)
        if array.dtype.kind != "U":
            raise refused(place, f"{shown(values)}: must be names")
        return array
    is_block = field.startswith("initial.")
    array = numbers(place, values, "" if is_block else described(FIELDS[field]).unit, is_block)
    if kind != FieldDescriptor.CPPTYPE_UINT32:
        return np.ascontiguousarray(array, "<c16" if array.dtype.kind == "c" else "<f8")
    if not ((array >= 0) & (array == np.floor(array)) & (array < 2.0**32)).all():
        raise refused(place, f"{shown(values)}: must be whole numbers of at least 0 and below 2^32")
    return array.astype("<i8")


def _methods(values: Any, place: str) -> NDArray[Any]:
    """Returns methods, given as mappings or names, as texts of JSON with sorted keys."""
    if isinstance(values, (str, Mapping)) or not hasattr(values, "__iter__"):
        raise refused(place, f"{shown(values)}: must be names or mappings such as {{'name': 'rk4'}}")
    texts = []
    for k, value in enumerate(values):
        try:
            message = to_method(value)
        except (InvalidArgument, TypeError) as error:
            raise refused(f"{place}[{k}]", str(error)) from None
        texts.append(json.dumps(to_dict(pb.Scene(method=message))["method"], sort_keys=True))
    return np.array(texts, "U")


def base_of(scene: Any, axes: Axes) -> pb.Scene:
    """Returns the scene without the fields that an axis sets as a whole. Raises InvalidArgument if the scene is itself
    an ensemble, or if an axis sets an entry that the scene's field does not have."""
    base = copy.deepcopy(to_message(scene))
    if base.HasField("members"):
        raise refused("scene.members", f"{base.members}: must be absent, the sweep makes its own ensembles")
    for axis in axes.axes:
        part, _, name = axis.field.partition(".")
        if part == "initial":
            base.initial.pop(name, None)
            base.initial_tensors.pop(name, None)
        elif axis.field not in COMMON:
            owner, name = owner_of(base, axis.field)
            there = len(getattr(owner, name))
            if axis.entry is None:
                owner.ClearField(name)
            elif axis.entry >= there:
                raise refused(f"axes[{axis.path!r}]", f"the scene's {axis.field} has {there} numbers: must have this one")
    return base
