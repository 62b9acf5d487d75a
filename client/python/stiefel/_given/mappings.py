"""The walk through what a caller gives for a message, dicts and lists of names. Errors name the path of every fault."""
from __future__ import annotations

import difflib
import functools
from dataclasses import dataclass, field
from typing import Any, Iterable, Mapping, Optional, TypeVar, Union

import numpy as np
from google.protobuf import json_format
from google.protobuf.descriptor import FieldDescriptor
from google.protobuf.message import Message

from stiefel import v1 as pb
from stiefel._given.numbers import Ensemble, block_of, list_of, number, refused, whole
from stiefel._given.shapes import described, is_repeated
from stiefel._given.shown import shown
from stiefel._wire.arrays import put_block
from stiefel.errors import InvalidArgument, Violation

Names = Union[str, Iterable[str]]
M = TypeVar("M", bound=Message)

#: What people call a field of a scene, and its name.
_OTHER_NAMES = {"omega": "angular_velocity", "w": "angular_velocity", "rates": "angular_velocity", "dt": "step", "h": "step",
                "quaternion": "attitude", "q": "attitude", "rotation": "attitude", "orientation": "attitude", "I": "inertia_tensor",
                "J": "inertia_tensor", "tensor": "inertia_tensor", "integrator": "method", "solver": "method", "t0": "epoch", "state": "initial"}
#: What acts on a body elsewhere.
_LOADS = ("torque", "torques", "external_torque", "force", "forces", "gravity", "gravity_gradient", "drag")
_KINDS = {FieldDescriptor.CPPTYPE_DOUBLE: "number", FieldDescriptor.CPPTYPE_UINT32: "whole", FieldDescriptor.CPPTYPE_UINT64: "long",
          FieldDescriptor.CPPTYPE_MESSAGE: "message", FieldDescriptor.CPPTYPE_ENUM: "choice", FieldDescriptor.CPPTYPE_STRING: "a text",
          FieldDescriptor.CPPTYPE_BOOL: "True or False"}
_NUMBERS = ("number", "list", "whole", "long")
_RULES = {"number": "a number", "whole": "a whole number of at least 0", "long": "a whole number of at least 0"}


@dataclass(frozen=True)
class Field:
    """An entry of the table of what a message takes."""

    name: str
    #: "number", "list", "whole" or "long", "choice" or "choices", "message", "blocks", "beside", which the walk hands on as it is
    #: given, or in words what the value must be.
    kind: str
    unit: str = ""
    count: str = ""  #: of a list, how many numbers are one motion's: a number, or the "rows" or "cols" of the blocks
    choices: Mapping[str, int] = field(default_factory=dict)


#: What a scene and its body may have beside the fields of the messages, which the client writes in other fields.
_BESIDE = {"Scene": (Field("normalize", "true or false"), Field("epoch", "beside")),
           "Body": (Field("order", "beside"), Field("mrp", "list", "", "3"), Field("euler_angles", "list", "rad", "3"),
                    Field("sequence", "beside"), Field("angular_momentum", "list", "kg*m**2/s", "3"), Field("frame", "beside"),
                    Field("euler_rates", "list", "rad/s", "3"))}


@functools.lru_cache(maxsize=None)
def _table(message: Any) -> dict[str, Field]:
    """Returns the entries of all fields by their names; protobuf's lowerCamelCase names are read too."""
    entries, descriptor = {}, message.DESCRIPTOR
    for field in descriptor.fields:
        kind, numbers, choices = _KINDS.get(field.cpp_type, "of the type in the protocol"), described(field), {}
        if is_repeated(field):
            kind = {"number": "list", "message": "blocks", "choice": "choices"}.get(kind, kind)
        if field.enum_type:  # DIRECTION_RISING of Direction is "rising"
            choices = {one.name[len(field.enum_type.name) + 1:].lower(): one.number for one in field.enum_type.values}
            unspecified = choices.pop("unspecified")
            choices.update({"both": unspecified} if field.name == "direction" else {})
        entries[field.json_name] = entries[field.name] = Field(field.name, kind, numbers.unit, numbers.count, choices)
    return {**entries, **{field.name: field for field in _BESIDE.get(descriptor.name, ())}}


class Walk:
    """The way through what a caller gives for a message: every value is read once, by its entry in the table. Faults are
    collected."""

    def __init__(self, members: Any = None):
        """`members`: the number of members of an ensemble, as a caller gives it; None for a single motion."""
        self.ensemble = Ensemble() if members is None else Ensemble.of(members)
        self.faults: list[Violation] = []
        #: What is read beside the messages, by name: all of a body, whose lists depend on each other.
        self.beside: dict[str, Any] = {}

    def read(self, given: Any, message: M, path: str) -> M:
        """Fills a message and returns it. Raises InvalidArgument with every unknown key and every wrong value."""
        self.fill(given, message, path)
        if self.faults:
            raise InvalidArgument(f"{self.faults[0].field}: {self.faults[0].description}", tuple(self.faults))
        return message

    def fill(self, given: Any, message: Any, path: str) -> None:
        """Sets the fields of a message. What is None is absent, as null in JSON."""
        kind: Any = type(message)
        table, of_body = _table(kind), kind is pb.Body
        if isinstance(given, str) and kind is pb.Method:
            given = {"name": given}
        if not isinstance(given, Mapping):
            may_be_name = "a name, or " * (kind is pb.Method)
            self.faults.append(Violation(path, f"{shown(given)}: must be {may_be_name}a mapping with the fields {_listed(table)}"))
            return
        if of_body and isinstance(given.get("body"), Mapping):
            self.faults.append(Violation(path, "is a whole scene, as stiefel.body_scene returns it: give it in place of the scene, "
                                               "{**stiefel.body_scene(...), ...}"))
            return
        # A form of a body needs lists of the right length, which else the server checks.
        strict = of_body and not {*given} <= {field.name for field in message.DESCRIPTOR.fields}
        for key in sorted(given, key=lambda key: key in table and table[key].kind in _NUMBERS):  # blocks tell the lengths of lists
            field, value = table.get(key), given[key]
            place = f"{path}.{field.name if field else key}".lstrip(".")
            try:
                if field is None:
                    raise refused(place, _unknown(str(key), value, kind))
                if value is None:
                    continue
                if field.kind in ("beside", "true or false"):
                    if field.kind != "beside" and not isinstance(value, bool):
                        raise refused(place, f"{shown(value)}: must be {field.kind}")
                    self.beside[field.name] = value
                elif field.kind == "number" and not isinstance(value, str):  # a text may be "NaN" in JSON
                    setattr(message, field.name, number(place, value, field.unit))
                elif field.kind in ("whole", "long") and not isinstance(value, str):
                    setattr(message, field.name, whole(place, value, bits=32 if field.kind == "whole" else 63))
                elif field.kind == "list":
                    if field.name == "inertia_tensor":
                        value = _of_solids(place, value, self.ensemble.members)
                    elif field.name == "attitude" and hasattr(value, "as_matrix"):  # a Rotation of scipy
                        value = value.as_matrix()
                    array = list_of(place, value, field.unit, field.count, self.ensemble, strict, field.name in ("inertia_tensor", "attitude"))
                    if of_body:
                        self.beside[field.name] = array
                    else:
                        getattr(message, field.name).extend(array.ravel().tolist())
                else:
                    self._set(place, value, message, field)
            except InvalidArgument as error:
                self.faults += error.violations

    def _set(self, place: str, value: Any, message: Any, field: Field) -> None:
        if field.kind == "message":
            part = getattr(message, field.name)
            part.SetInParent()
            self.fill(value, part, place)
        elif field.kind == "blocks":
            if not isinstance(value, Mapping):
                raise refused(place, f"{shown(value)}: must be a mapping from names to matrices")
            for name, block in value.items():
                block = as_block(f"{place}.{name}", block, self.ensemble)
                self.ensemble.see(block)
                if isinstance(block, Mapping):
                    self.fill(block, getattr(message, field.name)[name], f"{place}.{name}")
                else:
                    put_block(message, name, block)
        elif field.kind == "choice":
            setattr(message, field.name, _chosen(place, value, field))
        elif field.kind == "choices":
            getattr(message, field.name).extend(_chosen(place, one, field) for one in several(place, value))
        else:
            try:
                plain = value.tolist() if isinstance(value, (np.ndarray, np.generic)) else value
                json_format.ParseDict({field.name: plain}, message)
            except (json_format.ParseError, ValueError, TypeError, AttributeError):
                raise refused(place, f"{shown(value)}: must be {_RULES.get(field.kind, field.kind)}") from None


def _chosen(place: str, value: Any, field: Field) -> int:
    if not isinstance(value, str) or value not in field.choices:
        raise refused(place, f"{shown(value)}: must be one of {', '.join(field.choices)}")
    return field.choices[value]


def several(place: str, given: Any, what: str = "one") -> list[Any]:
    """Returns the elements of `given`, in which a text or a mapping is one element. `what`: what errors call an element."""
    if isinstance(given, (str, Mapping)):
        return [given]
    if not isinstance(given, Iterable):
        raise refused(place, f"{shown(given)}: must be {what} or several")
    return list(given)


def as_block(path: str, block: Any, ensemble: Ensemble = Ensemble()) -> Any:
    """Returns a block as an array, or the mapping of a Matrix with its rows and cols, or of a Tensor."""
    if not isinstance(block, Mapping):
        return block_of(path, block, ensemble)
    if not isinstance(block.get("values"), (list, tuple)) or not block["values"] or not isinstance(block["values"][0], (list, tuple)):
        return block
    if (unknown := sorted({*block} - {"values", "imaginary"})):
        raise refused(f"{path}.{unknown[0]}", "must be absent where values are nested lists")
    parts = [block_of(f"{path}.{name}", block[name], ensemble) for name in ("values", "imaginary") if name in block]
    if len(parts) == 2 and parts[0].shape != parts[1].shape:
        raise refused(f"{path}.imaginary", f"the shape {parts[1].shape}: must be that of values, {parts[0].shape}")
    return parts[0] if len(parts) == 1 else parts[0] + 1j * parts[1]


def _of_solids(place: str, given: Any, members: Optional[int]) -> Any:
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
    return [_of_solids(f"{place}[{k}]", one, None) for k, one in enumerate(given)] if some else given


def _unknown(key: str, value: Any, message: Any) -> str:
    """Returns a description that suggests the nearest name of a field, or of a field of a message inside, and lists all names."""
    table = _table(message)
    if key in _LOADS and message.DESCRIPTOR.name in _BESIDE:
        return f"unknown field; there are no torques and no forces: the motion is free (docs/conventions.md). It is {shown(value)}"
    paths = {name: f"{part}.{name}" for part, inside in (("method", pb.Method), ("body", pb.Body)) if part in table for name in _table(inside)}
    paths.update({name: field.name for name, field in table.items()})
    near = difflib.get_close_matches(key, paths, n=1) or [name for name in (_OTHER_NAMES.get(key),) if name in paths]
    listed = f"he fields are {_listed(table)}. It is {shown(value)}"
    return f"unknown field; did you mean {paths[near[0]]}? T{listed}" if near else f"unknown field; t{listed}"


def _listed(table: Mapping[str, Field]) -> str:
    return ", ".join(dict.fromkeys(field.name for field in table.values()))


def names(argument: str, given: Optional[Names]) -> list[str]:
    """Returns a list of names; a single text is one name. Raises InvalidArgument for elements that are not texts."""
    if given is None:
        return []
    result = list(given) if isinstance(given, Mapping) else several(argument, given, "a name")
    wrong = next((name for name in result if not isinstance(name, str)), None)
    if wrong is not None:
        raise refused(argument, f"{wrong!r}: must be a name")
    return result
