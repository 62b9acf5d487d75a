"""Fields of a scene by their paths, from the protocol, and inertia tensors."""
from __future__ import annotations

from typing import Any, Optional

import numpy as np
from google.protobuf.descriptor import FieldDescriptor
from numpy.typing import NDArray

from stiefel import v1 as pb
from stiefel._given.numbers import refused


def is_repeated(field: Any) -> bool:
    """Returns whether the field is a list or a map. New versions of protobuf have `is_repeated` and no `label`, old
    versions only `label`."""
    repeated = getattr(field, "is_repeated", None)
    return field.label == FieldDescriptor.LABEL_REPEATED if repeated is None else bool(repeated)


#: Fields of a scene and of its parts by their paths: "step", "body", "body.moments", "method.order".
FIELDS: dict[str, Any] = {field.name: field for field in pb.Scene.DESCRIPTOR.fields}
FIELDS.update({f"{part}.{field.name}": field for part, owner in list(FIELDS.items())
               if owner.message_type and not is_repeated(owner) for field in owner.message_type.fields})
_DOUBLES = [path for path, field in FIELDS.items() if field.cpp_type == FieldDescriptor.CPPTYPE_DOUBLE]
LISTS = tuple(path for path in _DOUBLES if is_repeated(FIELDS[path]))  #: lists of numbers by their paths
NUMBERS = tuple(path for path in _DOUBLES if path not in LISTS)  #: single numbers by their paths
TENSOR = "body.inertia_tensor"  #: which may be a symmetric matrix or a Solid, too
_OF_TENSOR = ((0, 1, 2, 0, 0, 1), (0, 1, 2, 1, 2, 2))  #: rows and columns of Ixx, Iyy, Izz, Ixy, Ixz, Iyz
_SYMMETRIC = 1e-10  #: the largest |I - I^T| / |I| of a symmetric matrix


def described(field: Any) -> pb.Numbers:
    """Returns what the protocol says of the numbers of a field: their unit, and how many are one motion's."""
    found: pb.Numbers = field.GetOptions().Extensions[pb.numbers]
    return found


def count_of(path: str) -> Optional[int]:
    """Returns how many numbers of a list are one motion's; None where its blocks decide it."""
    count = described(FIELDS[path]).count if path in FIELDS else ""
    return int(count) if count.isdigit() else None


def owner_of(scene: pb.Scene, path: str) -> tuple[Any, str]:
    """Returns the message that has the field, and the field's name in that message."""
    part, _, name = path.rpartition(".")
    return (getattr(scene, part) if part else scene), name


def of_symmetric(place: str, tensor: NDArray[Any]) -> NDArray[Any]:
    """Returns Ixx, Iyy, Izz, Ixy, Ixz, Iyz of matrices (..., 3, 3), which must be symmetric."""
    other = np.swapaxes(tensor, -1, -2)
    defect = np.abs(tensor - other).max(axis=(-1, -2))
    wrong = np.flatnonzero(np.ravel(defect > _SYMMETRIC * np.abs(tensor).max(axis=(-1, -2))))
    if wrong.size:
        which = f"[{wrong[0]}]" if tensor.ndim > 2 else ""
        raise refused(f"{place}{which}", f"max |I - I^T| = {np.ravel(defect)[wrong[0]]:.3g}: must be a symmetric matrix")
    return np.asarray((tensor / 2 + other / 2)[(..., *_OF_TENSOR)])
