"""Statistics, events, two-forms and brackets that a caller asks for, as messages."""
from __future__ import annotations

from typing import Any, Iterable, Mapping, Sequence, Union

import numpy as np

from stiefel import v1 as pb
from stiefel._given.numbers import number, numbers, refused, whole
from stiefel._given.shown import shown
from stiefel.scene import to_matrix

#: A statistic, several of them, or a mapping with the keys statistics, quantiles, edges, over_members.
Statistics = Union[str, Mapping[str, Any], Iterable[Union[str, Mapping[str, Any]]]]
Quantities = Mapping[str, Statistics]
#: An event as a mapping with the keys field, coefficients, level, direction, limit, terminal, plus, extremum.
EventDescription = Mapping[str, Any]
TangentVector = Mapping[str, Any]  #: blocks by name
Form = tuple[str, TangentVector, TangentVector]
Bracket = tuple[Sequence[tuple[Any, Any]], Sequence[tuple[Any, Any]]]

_STATISTICS: dict[str, int] = {name[len("STATISTIC_"):].lower(): number for name, number in pb.Statistic.items()}
_DIRECTIONS: dict[str, int] = {"both": pb.DIRECTION_UNSPECIFIED, "rising": pb.DIRECTION_RISING,
                               "falling": pb.DIRECTION_FALLING}
_KEYS = tuple(field.name for field in pb.Quantity.DESCRIPTOR.fields if field.name != "name")
_RULE = f"must be a statistic, several, or a mapping with the keys {', '.join(_KEYS)}"


def to_quantities(quantities: Quantities) -> list[pb.Quantity]:
    """Returns the messages for a mapping such as `{"energy": "drift", "M": ["min", {"quantiles": [0.1, 0.9]}]}`. Raises
    InvalidArgument that names what is malformed."""
    if not isinstance(quantities, Mapping):
        raise refused("quantities", f"{shown(quantities)}: must be a mapping from fields and invariants to statistics")
    return [_quantity(name, statistics) for name, statistics in quantities.items()]


def _quantity(name: str, statistics: Statistics) -> pb.Quantity:
    path = f"quantities.{name}"
    if not isinstance(name, str):
        raise refused(path, "must be a name")
    quantity = pb.Quantity(name=name)
    for item in _several(statistics, path):
        if isinstance(item, str):
            quantity.statistics.append(_number(_STATISTICS, item, path))
            continue
        if not isinstance(item, Mapping):
            raise refused(path, f"{shown(item)}: {_RULE}")
        for key, value in item.items():
            if key == "statistics":
                quantity.statistics.extend(_number(_STATISTICS, one, path) for one in _several(value, path))
            elif key == "over_members":
                quantity.over_members = _truth(f"{path}.{key}", value)
            elif key in _KEYS:
                getattr(quantity, key).extend(numbers(f"{path}.{key}", value).ravel().tolist())
            else:
                raise refused(path, f"{key!r}: must be one of {', '.join(_KEYS)}")
    return quantity


def _several(given: Any, path: str) -> list[Any]:
    """Returns the elements of `given`, in which a text or a mapping is one element."""
    if isinstance(given, (str, Mapping)):
        return [given]
    if not isinstance(given, Iterable):
        raise refused(path, f"{shown(given)}: {_RULE}")
    return list(given)


def to_events(events: Union[EventDescription, Sequence[EventDescription]]) -> list[pb.Event]:
    """Returns the messages for mappings such as `{"field": "angular_velocity", "coefficients": [0, 0, 1]}`. Raises
    InvalidArgument that names what is malformed."""
    if isinstance(events, str) or not isinstance(events, Iterable):
        raise refused("events", f"{shown(events)}: must be a mapping or several")
    given = [events] if isinstance(events, Mapping) else events
    return [_event(event, f"events[{i}]") for i, event in enumerate(given)]


def _event(description: EventDescription, path: str) -> pb.Event:
    event, keys = pb.Event(), ", ".join(field.name for field in pb.Event.DESCRIPTOR.fields)
    if not isinstance(description, Mapping):
        raise refused(path, f"{shown(description)}: must be a mapping with the keys {keys}")
    for key, value in description.items():
        place = f"{path}.{key}"
        if key == "coefficients":
            event.coefficients.extend(numbers(place, value).ravel().tolist())
        elif key == "direction":
            event.direction = _number(_DIRECTIONS, value, place)
        elif key == "level":
            event.level = number(place, value)
        elif key == "limit":
            event.limit = whole(place, value)
        elif key in ("terminal", "extremum"):
            setattr(event, key, _truth(place, value))
        elif key == "plus":
            if not isinstance(value, Mapping):
                raise refused(place, f"{shown(value)}: must be a mapping from fields to coefficients")
            for field, coefficients in value.items():
                event.plus.add(field=_name(place, field), coefficients=numbers(f"{place}.{field}", coefficients).ravel().tolist())
        elif key == "field":
            event.field = _name(place, value)
        else:
            raise refused(path, f"{key!r}: must be one of {keys}")
    return event


def _number(known: Mapping[str, int], name: Any, path: str) -> Any:
    if not isinstance(name, str) or name not in known or name == "unspecified":
        names = ", ".join(key for key in known if key != "unspecified")
        raise refused(path, f"{shown(name)}: must be one of {names}")
    return known[name]


def _name(path: str, value: Any) -> str:
    if not isinstance(value, str):
        raise refused(path, f"{shown(value)}: must be a name")
    return value


def _truth(path: str, value: Any) -> bool:
    if not isinstance(value, (bool, np.bool_)):
        raise refused(path, f"{shown(value)}: must be True or False")
    return bool(value)


def put_structure(request: pb.DiagnoseRequest, forms: Sequence[Form], brackets: Sequence[Bracket]) -> None:
    """Adds two-forms, each a name and two tangent vectors, and Dirac brackets, each two functions."""
    for i, (name, first, second) in enumerate(_parts("forms", forms, "a name and two tangent vectors", 3)):
        request.forms.add(form=name, first=_blocks(first, f"forms[{i}].first"), second=_blocks(second, f"forms[{i}].second"))
    for i, (one, other) in enumerate(_parts("dirac_brackets", brackets, "two functions", 2)):
        request.dirac_brackets.add(first=_factors(one, f"dirac_brackets[{i}].first"),
                                   second=_factors(other, f"dirac_brackets[{i}].second"))


def _parts(path: str, given: Any, rule: str, count: int) -> Any:
    """Returns a list whose elements have `count` parts each."""
    if not isinstance(given, (list, tuple)):
        raise refused(path, f"{shown(given)}: must be a list, each of {rule}")
    for i, one in enumerate(given):
        if not isinstance(one, (list, tuple)) or len(one) != count:
            raise refused(f"{path}[{i}]", f"{shown(one)}: must be {rule}")
    return given


def _blocks(vector: TangentVector, path: str) -> dict[str, pb.Matrix]:
    if not isinstance(vector, Mapping):
        raise refused(path, f"{shown(vector)}: must be a mapping from blocks to matrices")
    return {name: to_matrix(block, f"{path}.{name}") for name, block in vector.items()}


def _factors(factors: Sequence[tuple[Any, Any]], path: str) -> list[pb.LinearFunction]:
    return [pb.LinearFunction(a=to_matrix(A, f"{path}[{i}].A"), b=to_matrix(B, f"{path}[{i}].B"))
            for i, (A, B) in enumerate(_parts(path, factors, "two matrices A and B", 2))]
