"""Statistics and events that the server computes along with the steps."""
from __future__ import annotations

import reprlib
from dataclasses import dataclass, field
from typing import Any, Iterable, Mapping, Optional, Sequence, Union

import numpy as np
from numpy.typing import NDArray

from stiefel import v1 as pb
from stiefel.arrays import Array, Fields, Outcome, Price, RunStatus
from stiefel.compare import ByValue
from stiefel.given.numbers import number, numbers, refused, whole
from stiefel.replies import require

#: A statistic, several of them, or a mapping with the keys statistics, quantiles, edges, over_members.
Statistics = Union[str, Mapping[str, Any], Iterable[Union[str, Mapping[str, Any]]]]
Quantities = Mapping[str, Statistics]
#: An event as a mapping with the keys field, coefficients, level, direction, limit, terminal.
EventDescription = Mapping[str, Any]

_STATISTICS: dict[str, int] = {name[len("STATISTIC_"):].lower(): number for name, number in pb.Statistic.items()}
_DIRECTIONS: dict[str, int] = {"both": pb.DIRECTION_UNSPECIFIED, "rising": pb.DIRECTION_RISING,
                               "falling": pb.DIRECTION_FALLING}
_KEYS = ("statistics", "quantiles", "edges", "over_members")
_RULE = f"must be a statistic, several, or a mapping with the keys {', '.join(_KEYS)}"
_OUTCOMES = np.array([name[len("OUTCOME_"):] for name in pb.Outcome.keys()])


def to_quantities(quantities: Quantities) -> list[pb.Quantity]:
    """Returns the messages for a mapping such as `{"energy": "drift", "M": ["min", {"quantiles": [0.1, 0.9]}]}`. Raises
    InvalidArgument that names what is malformed."""
    if not isinstance(quantities, Mapping):
        raise refused("quantities", f"{reprlib.repr(quantities)}: must be a mapping from fields and invariants to statistics")
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
            raise refused(path, f"{reprlib.repr(item)}: {_RULE}")
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
        raise refused(path, f"{reprlib.repr(given)}: {_RULE}")
    return list(given)


def to_events(events: Union[EventDescription, Sequence[EventDescription]]) -> list[pb.Event]:
    """Returns the messages for mappings such as `{"field": "angular_velocity", "coefficients": [0, 0, 1]}`. Raises
    InvalidArgument that names what is malformed."""
    if isinstance(events, str) or not isinstance(events, Iterable):
        raise refused("events", f"{reprlib.repr(events)}: must be a mapping or several")
    given = [events] if isinstance(events, Mapping) else events
    return [_event(event, f"events[{i}]") for i, event in enumerate(given)]


def _event(description: EventDescription, path: str) -> pb.Event:
    event, keys = pb.Event(), ", ".join(pb.Event.DESCRIPTOR.fields_by_name)
    if not isinstance(description, Mapping):
        raise refused(path, f"{reprlib.repr(description)}: must be a mapping with the keys {keys}")
    for key, value in description.items():
        place = f"{path}.{key}"
        if key == "coefficients":
            event.coefficients.extend(numbers(place, value).ravel().tolist())
        elif key == "direction":
            event.direction = _number(_DIRECTIONS, value, path)
        elif key == "level":
            event.level = number(place, value)
        elif key == "limit":
            event.limit = whole(place, value)
        elif key == "terminal":
            event.terminal = _truth(place, value)
        elif key == "field":
            if not isinstance(value, str):
                raise refused(place, f"{reprlib.repr(value)}: must be a name")
            event.field = value
        else:
            raise refused(path, f"{key!r}: must be one of {keys}")
    return event


def _number(known: Mapping[str, int], name: Any, path: str) -> Any:
    if not isinstance(name, str) or name not in known or name == "unspecified":
        names = ", ".join(key for key in known if key != "unspecified")
        raise refused(path, f"{reprlib.repr(name)}: must be one of {names}")
    return known[name]


def _truth(path: str, value: Any) -> bool:
    if not isinstance(value, (bool, np.bool_)):
        raise refused(path, f"{reprlib.repr(value)}: must be True or False")
    return bool(value)


def check_statistics(arrays: Mapping[str, Array], request: pb.SummarizeRequest, ensemble: bool) -> None:
    """Raises CorruptReply unless `arrays` are those that the request asks for: one for each statistic, and how each motion
    ended."""
    wanted = {name: "i" for name in ("outcome", "last_step", "ended_by", "samples")}
    for quantity in request.quantities:
        of_quantity = [(pb.Statistic.Name(s)[len("STATISTIC_"):].lower(), "i" if s == pb.STATISTIC_SIGN_CHANGES else "fc")
                       for s in quantity.statistics]
        of_quantity += [("quantiles", "fc")] * bool(quantity.quantiles) + [("histogram", "i")] * bool(quantity.edges)
        wanted.update((f"{quantity.name}.{name}", kind) for name, kind in of_quantity)
    require(arrays.keys() == wanted.keys(), f"it has the statistics {', '.join(arrays)}")
    require(all(arrays[name].dtype.kind in kind for name, kind in wanted.items()), "a statistic has another data type")
    outcome = arrays["outcome"]
    require(outcome.ndim == ensemble and all(arrays[name].shape == outcome.shape for name in ("last_step", "ended_by")),
            "outcome, last_step and ended_by do not have one number for each motion")
    require(bool(((0 < outcome) & (outcome < len(_OUTCOMES))).all()), f"the outcomes are {outcome}")


@dataclass(frozen=True, eq=False, repr=False)
class Events(Fields):
    """Zeros of functions of the state, ordered by step: a mapping from field names to the fields at the zeros, with one
    element per zero in each array. Events are equal if all their arrays and their run statuses are equal."""

    event: NDArray[np.uint32]  #: the index of the event among those asked for
    step: NDArray[np.int64]  #: the last step before the zero
    #: The zero is at step + fraction, 0 < fraction <= 1. For a discrete system the fraction is 1, and the zero lies
    #: somewhere between the two steps.
    fraction: Array
    time: Array  #: (step + fraction) times the scene's step
    member: Optional[NDArray[np.uint32]]  #: the member of an ensemble; None for a single motion
    fields: dict[str, Array]  #: the fields at the zeros, (events, rows, cols)
    run_status: Optional[RunStatus] = None  #: how the run ended; None in the parts from `Session.stream_events`

    @property
    def count(self) -> int:
        """The number of zeros. `len` gives the number of fields, as for every mapping."""
        return len(self.step)

    def after(self, count: int) -> Events:
        """Returns the events after the first `count`."""
        return Events(self.event[count:], self.step[count:], self.fraction[count:], self.time[count:],
                      None if self.member is None else self.member[count:],
                      {name: values[count:] for name, values in self.fields.items()})

    @staticmethod
    def of(batch: pb.EventBatch, fields: dict[str, Array], ensemble: bool) -> Events:
        return Events(np.array(batch.events, np.uint32), np.array(batch.steps, np.int64), np.array(batch.fractions),
                      np.array(batch.times), np.array(batch.members, np.uint32) if ensemble else None, fields)

    @staticmethod
    def none(fields: Mapping[str, Array], ensemble: bool) -> Events:
        """Returns no events. `fields`: the fields of some state, which give names, shapes and types."""
        empty = {name: np.empty((0, *values.shape[ensemble:]), values.dtype) for name, values in fields.items()}
        return Events.of(pb.EventBatch(), empty, ensemble)

    @staticmethod
    def joined(parts: Sequence[Events], run_status: RunStatus) -> Events:
        """Returns the events of all parts, of which there must be one or more."""
        def join(name: str) -> Any:
            return np.concatenate([getattr(part, name) for part in parts])

        return Events(join("event"), join("step"), join("fraction"), join("time"),
                      None if parts[0].member is None else join("member"),
                      {name: np.concatenate([part.fields[name] for part in parts]) for name in parts[0].fields}, run_status)

    def __repr__(self) -> str:
        outcome = f" {self.run_status.outcome}" if self.run_status else ""
        return f"<stiefel.Events{outcome} of {self.count} zero{'s' if self.count != 1 else ''}: {self._shapes()}>"


@dataclass(frozen=True, eq=False, repr=False)
class Summary(ByValue, Mapping[str, "dict[str, Array]"]):
    """Statistics by quantity and name: `summary["energy"]["drift"]`. Two summaries are equal if all their arrays and their
    run statuses are equal, whatever they cost.

    The shape of an array is that of the field, () for a single invariant, or (invariants,) for a family. In an
    ensemble, (members,) stands before this shape; (quantiles,) or (bins,) stands behind it.
    """

    quantities: dict[str, dict[str, Array]]
    outcomes: Array  #: how each motion ended, texts equal to `Outcome`: (), in an ensemble (members,)
    last_step: Array  #: the last step of each motion: (), in an ensemble (members,)
    ended_by: Array  #: the index of the terminal event, or -1: (), in an ensemble (members,)
    samples: Array  #: the number of samples: (), in an ensemble (members,)
    run_status: RunStatus
    computed_steps: int = field(compare=False)
    price: Optional[Price] = field(default=None, compare=False)
    checkpoint: bytes = field(default=b"", compare=False)  #: the last checkpoint, if any was asked for
    #: whether the server ignored the call's checkpoint, because it does not have the key that signed it
    checkpoint_ignored: bool = field(default=False, compare=False)

    @property
    def outcome(self) -> Outcome:
        return self.run_status.outcome

    def __getitem__(self, name: str) -> dict[str, Array]:
        try:
            return self.quantities[name]
        except KeyError:
            raise KeyError(f"no quantity {name!r}; the quantities are {', '.join(self.quantities) or 'none'}") from None

    def __contains__(self, name: object) -> bool:
        return name in self.quantities

    def _ipython_key_completions_(self) -> list[str]:
        return list(self.quantities)

    def __iter__(self) -> Any:
        return iter(self.quantities)

    def __len__(self) -> int:
        return len(self.quantities)

    @staticmethod
    def of(arrays: Mapping[str, Array], run_status: RunStatus, computed_steps: int, price: Optional[Price],
           checkpoint: bytes, checkpoint_ignored: bool = False) -> Summary:
        quantities: dict[str, dict[str, Array]] = {}
        for name, values in arrays.items():
            quantity, dot, statistic = name.rpartition(".")
            if dot:
                quantities.setdefault(quantity, {})[statistic] = values
        return Summary(quantities, _OUTCOMES[arrays["outcome"]], arrays["last_step"], arrays["ended_by"],
                       arrays["samples"], run_status, computed_steps, price, checkpoint, checkpoint_ignored)

    def __repr__(self) -> str:
        what = ", ".join(f"{name} {'/'.join(statistics)}" for name, statistics in self.quantities.items())
        return f"<stiefel.Summary {self.outcome}: {what or 'nothing'}>"
