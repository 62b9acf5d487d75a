"""Shapes of the lists and blocks of a scene, for one motion and for the members of an ensemble."""
from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Iterable, Mapping, Optional

import numpy as np
from google.protobuf.descriptor import FieldDescriptor
from numpy.typing import NDArray

from stiefel import v1 as pb
from stiefel._given.attitudes import quaternions
from stiefel._given.mappings import is_repeated
from stiefel._given.numbers import numbers, refused, whole
from stiefel._given.shown import shown

#: Fields of a scene and of its parts by their paths: "step", "body", "body.moments", "method.order".
FIELDS: dict[str, Any] = {field.name: field for field in pb.Scene.DESCRIPTOR.fields}
FIELDS.update({f"{part}.{field.name}": field for part, owner in list(FIELDS.items())
               if owner.message_type and not is_repeated(owner) for field in owner.message_type.fields})
_DOUBLES = [path for path, field in FIELDS.items() if field.cpp_type == FieldDescriptor.CPPTYPE_DOUBLE]
LISTS = tuple(path for path in _DOUBLES if is_repeated(FIELDS[path]))  #: lists of numbers by their paths
NUMBERS = tuple(path for path in _DOUBLES if path not in LISTS)  #: single numbers by their paths
TENSOR = "body.inertia_tensor"  #: which may be a symmetric matrix or a Solid, too
ATTITUDE = "body.attitude"  #: which may be a rotation matrix or a Rotation of scipy, too
_OF_TENSOR = ((0, 1, 2, 0, 0, 1), (0, 1, 2, 1, 2, 2))  #: rows and columns of Ixx, Iyy, Izz, Ixy, Ixz, Iyz
_SYMMETRIC = 1e-10  #: the largest |I - I^T| / |I| of a symmetric matrix


def unit_of(path: str) -> str:
    """Returns the unit of a field of a scene; "" for none."""
    return str(_numbers(path).unit)


def count_of(path: str) -> Optional[int]:
    """Returns how many numbers of a list are one motion's; None where its blocks decide it."""
    count = _numbers(path).count
    return int(count) if count.isdigit() else None


def _numbers(path: str) -> pb.Numbers:
    found: pb.Numbers = FIELDS[path].GetOptions().Extensions[pb.numbers] if path in FIELDS else pb.Numbers()
    return found


def owner_of(scene: pb.Scene, path: str) -> tuple[Any, str]:
    """Returns the message that has the field, and the field's name in that message."""
    part, _, name = path.rpartition(".")
    return (getattr(scene, part) if part else scene), name


@dataclass(frozen=True)
class Ensemble:
    """The number of members, None for a single motion, and the shape of one member's blocks where it is known."""

    members: Optional[int] = None
    rows: Optional[int] = None
    cols: Optional[int] = None
    wrong: bool = False  #: whether the number of members is none, so that no shape fits and the number itself is refused

    @staticmethod
    def of(members: Any) -> Ensemble:
        """`members`: the field of a scene, which may be a text as in JSON."""
        if members is None:
            return Ensemble()
        try:
            return Ensemble(whole("members", int(members) if isinstance(members, str) else members, 1))
        except ValueError:  # InvalidArgument is one
            return Ensemble(wrong=True)

    def with_blocks(self, blocks: Iterable[Any]) -> Ensemble:
        """Returns this with the shape of the first block, an array or a Matrix as a mapping."""
        for block in blocks:
            shape: Any = (block.get("rows"), block.get("cols")) if isinstance(block, Mapping) else block.shape
            if isinstance(shape[-2], int) and isinstance(shape[-1], int):
                return replace(self, rows=shape[-2] // (self.members or 1) if len(shape) == 2 else shape[1], cols=shape[-1])
        return self

    def each(self, path: str) -> Optional[int]:
        """Returns how many numbers of a list are one member's; None where that is not known."""
        return count_of(path) or getattr(self, _numbers(path).count)


def list_of(path: str, given: Any, ensemble: Ensemble) -> list[float]:
    """Returns a list of a scene, flat. One that all members share may have the shape (numbers), one of each member's
    own (members, numbers). A list of Python's may also be flat, as in a scene file: one member after another. Raises
    InvalidArgument for any other shape."""
    place, members, each = f"scene.{path}", ensemble.members, ensemble.each(path)
    if path == ATTITUDE and hasattr(given, "as_quat"):
        given = quaternions(place, given)
    elif path == TENSOR:
        given = of_solids(place, given, members)
    array = numbers(place, given, unit_of(path))
    shape = array.shape
    if path == ATTITUDE and shape in ((3, 3), (members, 3, 3)):
        array = quaternions(place, array, rounded="stiefel.body(..., normalize=True)")
    if path == TENSOR and shape[-2:] == (3, 3):
        array = of_symmetric(place, array)
    if array.ndim == 1:
        is_flat = members is not None and members > 1 and each is not None and array.shape == (members * each,)
        fits = isinstance(given, (list, tuple)) or not is_flat
    else:
        fits = members is not None and array.ndim == 2 and array.shape == (members, each or array.shape[1])
    if not fits and not ensemble.wrong:
        what = shown(given) if isinstance(given, (int, float)) else f"the shape {shape}"
        raise refused(place, f"{what}: must be {_shapes(path, members, each)}")
    flat: list[float] = array.ravel().tolist()
    return flat


def block_of(path: str, given: Any, ensemble: Ensemble = Ensemble()) -> NDArray[Any]:
    """Returns a block, real or complex, with the shape (rows, cols); in an ensemble (members, rows, cols), or (members rows,
    cols). Raises InvalidArgument for any other shape. A block of one row may be given as (cols)."""
    array = numbers(path, given, may_be_complex=True, what="a matrix of numbers")
    if array.ndim == 1:
        array = array[np.newaxis]
    if array.ndim != 2 and not (array.ndim == 3 and (array.shape[0] == ensemble.members or ensemble.wrong)):
        of = ensemble.members
        fits = "(rows, cols)" if of is None else f"({of}, rows, cols), or ({of} rows, cols) with one member after another"
        raise refused(path, f"the shape {array.shape}: must be {fits}")
    return array


def of_solids(place: str, given: Any, members: Optional[int]) -> Any:
    """Returns the tensor of a Solid, or of a list of solids, which are one body; of a list of these one tensor for each member
    of an ensemble; what is given if it is none of these."""
    def is_solid(one: Any) -> bool:
        return hasattr(one, "inertia_tensor") and hasattr(one, "about")

    if is_solid(given):
        return given.inertia_tensor
    if not isinstance(given, (list, tuple)) or not given:
        return given
    if all(map(is_solid, given)):
        if members == len(given) > 1:
            raise refused(place, f"{members} solids for {members} members: must be [[solid], ...] for a body of each member, or "
                                 "sum(solids) for one that all share")
        whole_body: Any = sum(given)
        return whole_body.inertia_tensor
    some = any(is_solid(one) or isinstance(one, (list, tuple)) and len(one) and is_solid(one[0]) for one in given)
    return [of_solids(f"{place}[{k}]", one, None) for k, one in enumerate(given)] if some else given


def of_symmetric(place: str, tensor: NDArray[Any]) -> NDArray[Any]:
    """Returns Ixx, Iyy, Izz, Ixy, Ixz, Iyz of matrices (..., 3, 3), which must be symmetric."""
    other = np.swapaxes(tensor, -1, -2)
    defect = np.abs(tensor - other).max(axis=(-1, -2))
    wrong = np.flatnonzero(np.ravel(defect > _SYMMETRIC * np.abs(tensor).max(axis=(-1, -2))))
    if wrong.size:
        which = f"[{wrong[0]}]" if tensor.ndim > 2 else ""
        raise refused(f"{place}{which}", f"max |I - I^T| = {np.ravel(defect)[wrong[0]]:.3g}: must be a symmetric matrix")
    return np.asarray((tensor / 2 + other / 2)[(..., *_OF_TENSOR)])


def _shapes(path: str, members: Optional[int], each: Optional[int]) -> str:
    one = [f"({each or 'numbers'})"] + (["(3, 3)"] if path in (TENSOR, ATTITUDE) else [])
    own = [] if members is None else [f"({members}, {shape[1:]}" for shape in one]
    return " or ".join(one + own)
