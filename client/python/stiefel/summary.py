"""Statistics and events that the server computes along with the steps."""
from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Iterable, Mapping, Optional, Sequence, Union

import numpy as np
from numpy.typing import NDArray

from stiefel import v1 as pb
from stiefel.arrays import Array, Outcome, Price, RunStatus
from stiefel.errors import InvalidArgument, Violation

#: A statistic, several of them, or a mapping with the keys statistics, quantiles, edges, over_members.
Statistics = Union[str, Mapping[str, Any], Iterable[Union[str, Mapping[str, Any]]]]
Quantities = Mapping[str, Statistics]
#: An event as a mapping with the keys field, coefficients, level, direction, limit, terminal.
EventDescription = Mapping[str, Any]

_STATISTICS: dict[str, int] = {name[len("STATISTIC_"):].lower(): number for name, number in pb.Statistic.items()}
_DIRECTIONS: dict[str, int] = {"both": pb.DIRECTION_UNSPECIFIED, "rising": pb.DIRECTION_RISING,
                               "falling": pb.DIRECTION_FALLING}
_KEYS = ("statistics", "quantiles", "edges", "over_members")
_OUTCOMES = np.array([name[len("OUTCOME_"):] for name in pb.Outcome.keys()])


def to_quantities(quantities: Quantities) -> list[pb.Quantity]:
    """Returns the messages for a mapping such as `{"energy": "drift", "M": ["min", {"quantiles": [0.1, 0.9]}]}`."""
    return [_quantity(name, statistics) for name, statistics in quantities.items()]


def _quantity(name: str, statistics: Statistics) -> pb.Quantity:
    quantity = pb.Quantity(name=name)
    for item in [statistics] if isinstance(statistics, (str, Mapping)) else statistics:
        if isinstance(item, str):
            quantity.statistics.append(_number(_STATISTICS, item, f"quantities.{name}"))
            continue
        for key, value in item.items():
            if key == "statistics":
                given = [value] if isinstance(value, str) else value
                quantity.statistics.extend(_number(_STATISTICS, one, f"quantities.{name}") for one in given)
            elif key == "over_members":
                quantity.over_members = bool(value)
            elif key in _KEYS:
                getattr(quantity, key).extend(np.atleast_1d(np.asarray(value, float)).tolist())
            else:
                raise _refused(f"quantities.{name}", f"{key!r}: must be one of {', '.join(_KEYS)}")
    return quantity


def to_events(events: Union[EventDescription, Sequence[EventDescription]]) -> list[pb.Event]:
    """Returns the messages for mappings such as `{"field": "angular_velocity", "coefficients": [0, 0, 1]}`."""
    given = [events] if isinstance(events, Mapping) else events
    return [_event(event, f"events[{i}]") for i, event in enumerate(given)]


def _event(description: EventDescription, path: str) -> pb.Event:
    event = pb.Event()
    for key, value in description.items():
        if key == "coefficients":
            event.coefficients.extend(np.asarray(value, float).ravel().tolist())
        elif key == "direction":
            event.direction = _number(_DIRECTIONS, value, path)
        elif key in ("field", "level", "limit", "terminal"):
            setattr(event, key, value)
        else:
            raise _refused(path, f"{key!r}: must be one of {', '.join(pb.Event.DESCRIPTOR.fields_by_name)}")
    return event


def _number(known: Mapping[str, int], name: str, path: str) -> Any:
    if name not in known or name == "unspecified":
        raise _refused(path, f"{name!r}: must be one of {', '.join(key for key in known if key != 'unspecified')}")
    return known[name]


def _refused(path: str, rule: str) -> InvalidArgument:
    return InvalidArgument(f"{path}: {rule}", (Violation(path, rule),))


@dataclass(frozen=True, eq=False, repr=False)
class Events:
    """Zeros of functions of the state, ordered by step. Each array has one element per zero."""

    event: NDArray[np.uint32]  #: the index of the event among those asked for
    step: NDArray[np.int64]  #: the last step before the zero
    #: The zero is at step + fraction, 0 < fraction <= 1. For a discrete system the fraction is 1, and the zero lies
    #: somewhere between the two steps.
    fraction: Array
    time: Array  #: (step + fraction) times the scene's step
    member: Optional[NDArray[np.uint32]]  #: the member of an ensemble; None for a single motion
    fields: dict[str, Array]  #: the fields at the zeros, (events, rows, cols)
    run_status: Optional[RunStatus] = None  #: how the run ended; None in the parts from `Session.stream_events`

    def __len__(self) -> int:
        return len(self.step)

    def __getitem__(self, name: str) -> Array:
        return self.fields[name]

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
    def joined(parts: Sequence[Events], run_status: RunStatus) -> Events:
        def join(name: str, dtype: Any) -> Any:
            return np.concatenate([np.empty(0, dtype), *(getattr(part, name) for part in parts)])

        ensemble = bool(parts) and parts[0].member is not None
        names = parts[0].fields if parts else {}
        return Events(join("event", np.uint32), join("step", np.int64), join("fraction", float), join("time", float),
                      join("member", np.uint32) if ensemble else None,
                      {name: np.concatenate([part.fields[name] for part in parts]) for name in names}, run_status)

    def __repr__(self) -> str:
        return f"<stiefel.Events: {len(self)}>"


@dataclass(frozen=True, eq=False, repr=False)
class Summary(Mapping[str, "dict[str, Array]"]):
    """Statistics by quantity and name: `summary["energy"]["drift"]`.

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
        return self.quantities[name]

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
