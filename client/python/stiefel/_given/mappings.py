"""Converts what a caller gives, dicts and lists of names, for messages. Errors name the path of every fault."""
from __future__ import annotations

import difflib
from typing import Any, Iterable, Iterator, Mapping, Optional, Union

from google.protobuf import json_format
from google.protobuf.descriptor import FieldDescriptor
from google.protobuf.message import Message

from stiefel._given.shown import shown
from stiefel.errors import InvalidArgument, Violation

Names = Union[str, Iterable[str]]

#: What people call a field of a scene, and its names.
_OTHER_NAMES = {"omega": ("angular_velocity",), "w": ("angular_velocity",), "rates": ("angular_velocity",), "dt": ("step",), "h": ("step",),
                "quaternion": ("attitude",), "q": ("attitude",), "rotation": ("attitude",), "orientation": ("attitude",), "I": ("inertia_tensor",),
                "J": ("inertia_tensor",), "tensor": ("inertia_tensor",), "integrator": ("method",), "solver": ("method",), "t0": ("epoch",), "state": ("initial",)}
#: What a scene and its body may have beside the fields of the messages, which the client writes in other fields.
BESIDE = {"Scene": ("normalize", "epoch"), "Body": ("order", "mrp", "angular_momentum", "frame")}
#: What acts on a body elsewhere.
_LOADS = ("torque", "torques", "external_torque", "force", "forces", "gravity", "gravity_gradient", "drag")
_KINDS = {
    FieldDescriptor.CPPTYPE_DOUBLE: ("a number", "numbers"),
    FieldDescriptor.CPPTYPE_STRING: ("a text", "texts"),
    FieldDescriptor.CPPTYPE_UINT32: ("a whole number of at least 0 and below 2^32", "whole numbers of at least 0 and below 2^32"),
    FieldDescriptor.CPPTYPE_UINT64: ("a whole number of at least 0", "whole numbers of at least 0"),
}


def parse(mapping: Any, message: Message, path: str) -> None:
    """Fills the message. Raises InvalidArgument with every unknown key and every value of a wrong type."""
    try:
        json_format.ParseDict(mapping, message)
    except (json_format.ParseError, ValueError, TypeError, AttributeError) as error:
        found = tuple(violations(mapping, type(message), path)) or (Violation(path, str(error)),)
        raise InvalidArgument(f"{found[0].field}: {found[0].description}", found) from None


def violations(mapping: Any, kind: type[Message], path: str) -> Iterator[Violation]:
    """Yields every fault that keeps `mapping` from being a message of the type `kind`."""
    descriptor: Any = kind.DESCRIPTOR  # of protobuf's own types, which differ between its implementations
    if not isinstance(mapping, Mapping):
        may_be_name = "a name, or " * (descriptor.name == "Method")
        yield Violation(path, f"{shown(mapping)}: must be {may_be_name}a mapping with the fields {', '.join(_names_of(descriptor))}")
        return
    known_fields = {name: field for field in descriptor.fields for name in (field.json_name, field.name)}
    for key, value in mapping.items():
        field = known_fields.get(key)
        if field is None:
            yield Violation(f"{path}.{key}", _unknown(str(key), value, descriptor))
        elif field.message_type is None:
            yield from _of_scalar(key, value, kind, field, path)
        elif field.message_type.GetOptions().map_entry and not isinstance(value, Mapping):
            yield Violation(f"{path}.{key}", f"{shown(value)}: must be a mapping from names to matrices")
        elif field.message_type.GetOptions().map_entry:
            of = field.message_type.fields_by_name["value"].message_type._concrete_class
            for name, item in value.items():
                yield from violations(item, of, f"{path}.{key}.{name}")
        else:
            yield from violations(value, field.message_type._concrete_class, f"{path}.{key}")


def _of_scalar(key: str, value: Any, kind: type[Message], field: Any, path: str) -> Iterator[Violation]:
    try:
        json_format.ParseDict({key: value}, kind())
    except (json_format.ParseError, ValueError, TypeError, AttributeError) as error:
        what = _KINDS.get(field.cpp_type)
        rule = f"must be {what[is_repeated(field)]}" if what else str(error)
        yield Violation(f"{path}.{key}", f"{shown(value)}: {rule}")


def is_repeated(field: Any) -> bool:
    """Returns whether the field is a list or a map. New versions of protobuf have `is_repeated` and no `label`, old
    versions only `label`."""
    repeated = getattr(field, "is_repeated", None)
    return field.label == FieldDescriptor.LABEL_REPEATED if repeated is None else bool(repeated)


def _unknown(key: str, value: Any, descriptor: Any) -> str:
    """Returns a description that suggests the nearest name of a field, or of a field of a message inside; if none is
    near, one that lists all names."""
    if key in _LOADS and descriptor.name in BESIDE:
        return f"unknown field; there are no torques and no forces: the motion is free (docs/conventions.md). It is {shown(value)}"
    paths = {name: f"{outer.name}.{name}" for outer in descriptor.fields if outer.message_type and not is_repeated(outer)
             for name in _names_of(outer.message_type)}
    paths.update({name: name for name in _names_of(descriptor)})
    near = difflib.get_close_matches(key, paths, n=1) or [name for name in _OTHER_NAMES.get(key, ()) if name in paths][:1]
    hint = f"did you mean {paths[near[0]]}?" if near else f"the fields are {', '.join(_names_of(descriptor))}."
    return f"unknown field; {hint} It is {shown(value)}"


def _names_of(descriptor: Any) -> list[str]:
    return [*(field.name for field in descriptor.fields), *BESIDE.get(descriptor.name, ())]


def names(argument: str, given: Optional[Names]) -> list[str]:
    """Returns a list of names; a single text is one name. Raises InvalidArgument for elements that are not texts."""
    if given is None:
        return []
    if isinstance(given, str):
        return [given]
    if not isinstance(given, Iterable):
        raise InvalidArgument(f"{argument}: {shown(given)}: must be a name or several")
    result = list(given)
    wrong = [Violation(argument, f"{name!r}: must be a name") for name in result if not isinstance(name, str)]
    if wrong:
        raise InvalidArgument(f"{argument}: {wrong[0].description}", tuple(wrong))
    return result
