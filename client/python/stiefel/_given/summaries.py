"""Statistics, events, two-forms and brackets that a caller asks for, as messages."""
from __future__ import annotations

from typing import Any, Iterable, Mapping, Sequence, Union

from stiefel import v1 as pb
from stiefel._given.mappings import Walk, several
from stiefel._given.numbers import numbers, refused
from stiefel._given.shown import shown
from stiefel.scene import to_matrix

#: A statistic, several of them, or a mapping with the keys statistics, quantiles, edges, over_members.
Statistics = Union[str, Mapping[str, Any], Iterable[Union[str, Mapping[str, Any]]]]
Quantities = Mapping[str, Statistics]
#: An event as a mapping with the keys field, coefficients, level, direction, limit, terminal, plus.
EventDescription = Mapping[str, Any]
TangentVector = Mapping[str, Any]  #: blocks by name
Form = tuple[str, TangentVector, TangentVector]
Bracket = tuple[Sequence[tuple[Any, Any]], Sequence[tuple[Any, Any]]]


def to_quantities(quantities: Quantities) -> list[pb.Quantity]:
    """Returns the messages for a mapping such as `{"energy": "drift", "M": ["min", {"quantiles": [0.1, 0.9]}]}`. Raises
    InvalidArgument that names what is malformed."""
    if not isinstance(quantities, Mapping):
        raise refused("quantities", f"{shown(quantities)}: must be a mapping from fields and invariants to statistics")
    found = []
    for name, statistics in quantities.items():
        path = f"quantities.{name}"
        if not isinstance(name, str):
            raise refused(path, "must be a name")
        quantity = pb.Quantity()
        for item in several(path, statistics):
            Walk().read({"statistics": item} if isinstance(item, str) else item, quantity, path)
        if quantity.name:
            raise refused(f"{path}.name", f"{quantity.name!r}: must be absent: the key is the name")
        quantity.name = name
        found.append(quantity)
    return found


def to_events(events: Union[EventDescription, Sequence[EventDescription]]) -> list[pb.Event]:
    """Returns the messages for mappings such as `{"field": "angular_velocity", "coefficients": [0, 0, 1]}`. Raises
    InvalidArgument that names what is malformed."""
    if isinstance(events, str):
        raise refused("events", f"{shown(events)}: must be a mapping or several")
    found = []
    for i, given in enumerate(several("events", events)):
        plus, path = given.get("plus", {}) if isinstance(given, Mapping) else {}, f"events[{i}]"
        if not isinstance(plus, Mapping) or not all(isinstance(field, str) for field in plus):
            raise refused(f"{path}.plus", f"{shown(plus)}: must be a mapping from fields to coefficients")
        event = Walk().read({**given, "plus": None} if plus else given, pb.Event(), path)
        for field, coefficients in plus.items():
            event.plus.add(field=field, coefficients=numbers(f"{path}.plus.{field}", coefficients).ravel().tolist())
        found.append(event)
    return found


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
