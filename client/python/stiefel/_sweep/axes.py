"""Axes of a sweep: values for fields of a scene, as a grid or side by side."""
from __future__ import annotations

import json
import re
from dataclasses import dataclass
from typing import Any, Mapping, Optional

import numpy as np
from google.protobuf import json_format
from google.protobuf.descriptor import FieldDescriptor
from numpy.typing import NDArray

from stiefel import v1 as pb
from stiefel._given.shown import shown
from stiefel.errors import InvalidArgument, Violation
from stiefel._given.numbers import numbers
from stiefel._given.shapes import FIELDS, LISTS, NUMBERS, TENSOR, count_of, of_symmetric, owner_of, unit_of
from stiefel.scene import to_message, to_method

#: Fields that all members of an ensemble share. Points that differ in one of them belong to different ensembles.
COMMON = (*(path for path in NUMBERS if "." not in path), "method", *(path for path in FIELDS if path.startswith("method.")))
SKEW = "initial.M"  #: a skew-symmetric block: an entry that varies sets the opposite one to its negative
POINT = "point"  #: the name of the dimension of axes side by side
_ENTRY = re.compile(r"(.+)\[(\d+)(?:, *(\d+))?\]")


@dataclass(frozen=True, eq=False)
class Axis:
    """The values along one axis."""

    path: str
    field: str  #: the path without an index
    entry: Optional[tuple[int, ...]]  #: the index of the one number of the field that varies; None for the whole field
    values: NDArray[Any]  #: for a list (points, numbers), for a block (points, rows, cols), else (points,)

    @property
    def common(self) -> bool:
        return self.field in COMMON


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
    """Checks paths and shapes and returns the axes. Raises InvalidArgument that names every wrong axis."""
    if not isinstance(axes, Mapping) or not axes:
        raise _wrong([Violation("axes", f"{shown(axes)}: must be a mapping from paths into the scene to values")])
    read: list[Axis] = []
    wrong: list[Violation] = []
    for path, values in axes.items():
        try:
            read.append(_axis(path, values))
        except InvalidArgument as error:
            wrong += error.violations
    if wrong:
        raise _wrong(wrong)
    result = Axes(tuple(read), zipped)
    _check_together(result)
    return result


def _axis(path: Any, values: Any) -> Axis:
    place = f"axes[{path!r}]"
    if not isinstance(path, str):
        raise _wrong([Violation(place, "must be a path into the scene")])
    found = _ENTRY.fullmatch(path)
    field = found[1] if found else path
    entry = tuple(int(index) for index in found.groups()[1:] if index is not None) if found else None
    rank = _rank(path, field, entry, place)
    array = _values(field, values, place)
    if field.startswith("initial.") and rank == 3 and array.ndim == 2:
        array = array[:, np.newaxis, :]  # a block of one row
    if field == TENSOR and rank == 2 and array.ndim == 3 and array.shape[1:] == (3, 3):
        array = of_symmetric(place, array)
    each = count_of(field)
    shape = {1: "(points)", 2: f"(points, {each or 'dimension'})", 3: "(points, rows, cols)"}[rank]
    if array.ndim != rank or 0 in array.shape or (rank == 2 and each not in (None, array.shape[1])):
        raise _wrong([Violation(place, f"the shape {array.shape}: must be {shape}")])
    return Axis(path, field, entry, array)


def _values(field: str, values: Any, place: str) -> NDArray[Any]:
    """Returns the values in the little-endian type in which they travel."""
    if field == "method":
        return _methods(values, place)
    if _kind(field) == FieldDescriptor.CPPTYPE_STRING:
        array = np.asarray(values) if np.ndim(values) == 1 else np.empty(0)
        if array.dtype.kind != "U":
            raise _wrong([Violation(place, f"{shown(values)}: must be names")])
        return array
    array = numbers(place, values, unit_of(field), field.startswith("initial."))
    if _kind(field) != FieldDescriptor.CPPTYPE_UINT32:
        return np.ascontiguousarray(array, "<c16" if array.dtype.kind == "c" else "<f8")
    if not ((array >= 0) & (array == np.floor(array)) & (array < 2.0**32)).all():
        raise _wrong([Violation(place, f"{shown(values)}: must be whole numbers of at least 0 and below 2^32")])
    return array.astype("<i8")


def _methods(values: Any, place: str) -> NDArray[Any]:
    """Returns methods, given as mappings or names, as texts of JSON with sorted keys."""
    if isinstance(values, (str, Mapping)) or not hasattr(values, "__iter__"):
        raise _wrong([Violation(place, f"{shown(values)}: must be names or mappings such as {{'name': 'rk4'}}")])
    texts = []
    for k, value in enumerate(values):
        try:
            message = to_method(value)
        except (InvalidArgument, TypeError) as error:
            raise _wrong([Violation(f"{place}[{k}]", str(error))]) from None
        texts.append(json.dumps(json_format.MessageToDict(message, preserving_proto_field_name=True), sort_keys=True))
    return np.array(texts, "U")


def _rank(path: str, field: str, entry: Optional[tuple[int, ...]], place: str) -> int:
    """Returns how many dimensions the array of values for a path must have."""
    whole = 3 if field.startswith("initial.") and field != "initial." else 2 if field in LISTS else 1 if field in COMMON else 0
    if whole == 0:
        known = ", ".join((*LISTS, "initial.BLOCK", *COMMON))
        raise _wrong([Violation(place, f"{path}: must be a field that a sweep varies: {known}")])
    if entry is None:
        return whole
    if len(entry) != whole - 1:
        raise _wrong([Violation(place, f"{path}: must have {whole - 1} indices, or none for the whole field")])
    return 1


def _check_together(axes: Axes) -> None:
    wrong = []
    if axes.zipped:
        sizes = {axis.path: len(axis.values) for axis in axes.axes}
        if len(set(sizes.values())) > 1:
            wrong.append(Violation("axes", f"{sizes}: must have as many values each, because they stand side by side"))
    for one in axes.axes:
        others = [axis for axis in axes.axes if axis is not one and (
            axis.field == one.field or axis.field.startswith(f"{one.field}.") and one.field == "method")]
        taken = (None, one.entry, one.entry[::-1] if one.entry and one.field == SKEW else None)
        if others and (one.entry is None or any(axis.entry in taken for axis in others)):
            wrong.append(Violation(f"axes[{one.path!r}]", f"{others[0].path} is an axis too: must be different numbers"))
    if wrong:
        raise _wrong(wrong)


def base_of(scene: Any, axes: Axes) -> pb.Scene:
    """Returns the scene without the fields that an axis sets as a whole. Raises InvalidArgument if the scene is itself
    an ensemble, or if an axis sets an entry that the scene's field does not have."""
    base = pb.Scene()
    base.CopyFrom(to_message(scene))
    wrong = []
    if base.HasField("members"):
        wrong.append(Violation("scene.members", f"{base.members}: must be absent, the sweep makes its own ensembles"))
    for axis in axes.axes:
        if axis.entry is not None:
            if axis.field == SKEW and axis.entry[0] == axis.entry[1]:
                wrong.append(Violation(f"axes[{axis.path!r}]", "must be off the diagonal, because M is skew-symmetric"))
            shape = _shape(base, axis.field)
            if len(shape) != len(axis.entry) or any(k >= size for k, size in zip(axis.entry, shape)):
                there = f"has the shape {shape}" if shape else "is absent"
                wrong.append(Violation(f"axes[{axis.path!r}]", f"the scene's {axis.field} {there}: must have this entry"))
        elif not axis.common:
            clear(base, axis.field)
    if wrong:
        raise _wrong(wrong)
    return base


def _shape(scene: pb.Scene, field: str) -> tuple[int, ...]:
    if field.startswith("initial."):
        name = field[len("initial."):]
        if name in scene.initial_tensors:
            return tuple(scene.initial_tensors[name].shape)
        return (scene.initial[name].rows, scene.initial[name].cols) if name in scene.initial else ()
    owner, name = owner_of(scene, field)
    return (len(getattr(owner, name)),) if len(getattr(owner, name)) else ()


def clear(scene: pb.Scene, field: str) -> None:
    if field.startswith("initial."):
        name = field[len("initial."):]
        scene.initial.pop(name, None)
        scene.initial_tensors.pop(name, None)
        return
    owner, name = owner_of(scene, field)
    owner.ClearField(name)


def set_common(scene: pb.Scene, field: str, value: Any) -> None:
    """Sets a number, a name or a method that all members share."""
    if field == "method":
        scene.method.CopyFrom(to_method(json.loads(value)))
        return
    owner, name = owner_of(scene, field)
    kinds: dict[Any, Any] = {FieldDescriptor.CPPTYPE_STRING: str, FieldDescriptor.CPPTYPE_UINT32: int}
    setattr(owner, name, kinds.get(_kind(field), float)(value))


def _kind(field: str) -> Optional[int]:
    """Returns the type of a field as protobuf numbers it; None for a block."""
    return int(FIELDS[field].cpp_type) if field in FIELDS else None


def _wrong(violations: list[Violation]) -> InvalidArgument:
    return InvalidArgument("; ".join(f"{v.field}: {v.description}" for v in violations), tuple(violations))
