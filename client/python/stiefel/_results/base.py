"""What results have in common: how a run ended, the price of a step, fields by name, and equality by value."""
from __future__ import annotations

import dataclasses
import enum
from dataclasses import dataclass
from typing import Any, Callable, ClassVar, Iterator, Mapping, Optional, Sequence, TypeVar

import numpy as np
from numpy.typing import NDArray

from stiefel._given.shown import shown
from stiefel._results.html import Shown

N = TypeVar("N", bound="Named")
Array = NDArray[Any]  # float64, complex128, or float32 in a scene whose scalar is "float"


def same(first: Any, second: Any) -> bool:
    """Returns whether both hold the same numbers. A NaN equals a NaN, and -0.0 equals 0.0."""
    if isinstance(first, np.ndarray) or isinstance(second, np.ndarray):
        numbers = all(np.asarray(one).dtype.kind in "fc" for one in (first, second))  # others are never NaN
        return np.array_equal(first, second, equal_nan=numbers)
    if isinstance(first, dict) and isinstance(second, dict):
        return first.keys() == second.keys() and all(same(first[key], second[key]) for key in first)
    if isinstance(first, tuple) and isinstance(second, tuple):
        return len(first) == len(second) and all(map(same, first, second))
    return bool(first == second)


class ByValue(Shown):
    """Base of dataclasses that are compared field by field, without the fields that have `compare=False`.

    The dataclass must have eq=False. It cannot be hashed, because it may hold arrays.
    """

    __hash__ = None  # type: ignore[assignment]

    def __eq__(self, other: object) -> bool:
        if type(other) is not type(self):
            return NotImplemented
        return all(same(getattr(self, field.name), getattr(other, field.name))
                   for field in dataclasses.fields(self) if field.compare)  # type: ignore[arg-type]


class Word(str, enum.Enum):
    """One of several words. Its text is the word."""

    def __str__(self) -> str:
        return str(self.value)


class Outcome(Word):
    """How a run ended. Anything but REACHED is a numerical stop with the last good state."""

    REACHED = "REACHED"
    LEFT_DOMAIN = "LEFT_DOMAIN"
    SOLVER_STALLED = "SOLVER_STALLED"
    NOT_FINITE = "NOT_FINITE"
    CANCELLED = "CANCELLED"


@dataclass(frozen=True)
class RunStatus(Shown):
    """How a run ended, with the reason."""

    outcome: Outcome
    #: For LEFT_DOMAIN: the largest |h| with which all substeps of the next step have a solution, or None.
    largest_step: Optional[float] = None
    message: str = ""  #: the reason in one sentence; empty when REACHED
    #: In an ensemble: the member that stopped first, counted from 0.
    member: Optional[int] = None


class Ended(Shown):
    """What has a run status."""

    run_status: RunStatus

    @property
    def outcome(self) -> Outcome:
        """How the run ended; `run_status` has the reason."""
        return self.run_status.outcome

    @property
    def status(self) -> int:
        """0 if the run reached its end, -1 if it stopped before, as in the results of SciPy."""
        return 0 if self.success else -1

    @property
    def success(self) -> bool:
        """Whether the run reached its end."""
        return self.outcome is Outcome.REACHED

    @property
    def message(self) -> str:
        """How the run ended, in one sentence."""
        return self.run_status.message or ("The run reached its end." if self.success else f"The run ended: {self.outcome}.")


@dataclass(frozen=True)
class Price(Shown):
    """What a step takes, predicted from its scene."""

    work: float  #: instructions
    bytes: int  #: bytes of the arrays of a sample


class Named(ByValue):
    """What has fields by their names: `state["Q"]`."""

    fields: dict[str, Array]
    _side: ClassVar[Optional[str]] = ""  #: how the frame of the system moves, as `Origin.side`

    def _of(self: N, side: "Optional[str] | Callable[[], Optional[str]]") -> N:
        """Tells how the frame moves. A function is called if there are fields for which it matters."""
        object.__setattr__(self, "_side", side if not callable(side) else side() if self.fields.keys() & {"Q", "M"} else "")
        return self

    def _slice(self: N, which: Any, **more: Any) -> N:
        """Returns a copy with the elements of a slice, or of those indices, in all arrays. `more`: other fields of the dataclass."""
        arrays = {name: values[which] for name, values in vars(self).items() if isinstance(values, np.ndarray)}
        fields = {name: values[which] for name, values in self.fields.items()}
        return dataclasses.replace(self, fields=fields, **arrays, **more)._of(self._side)  # type: ignore[type-var]

    def _field(self, name: object) -> Array:
        """Returns a field. Raises KeyError, which lists the fields that there are."""
        try:
            return self.fields[name]  # type: ignore[index]
        except (KeyError, TypeError):
            there = ", ".join(self.fields) or "none"
            if not isinstance(name, str):
                raise KeyError(f"no field {shown(name)}: must be a name, one of {there}; a list of indices or a mask picks "
                               "samples of a field's array: [name][mask]") from None
            raise KeyError(f"no field {name!r}; the fields are {there}; `fields={[name]!r}` asks for it if the system has it") from None

    def __array__(self, *arguments: Any, **more: Any) -> Any:
        """Raises TypeError: one array does not hold fields of different shapes."""
        raise TypeError(f"{type(self).__name__} is several arrays, {self._shapes()}: take one of them by its name, [{next(iter(self.fields), 'name')!r}]")

    def __contains__(self, name: object) -> bool:
        """Returns whether there is a field of this name."""
        return isinstance(name, str) and name in self.fields

    def _ipython_key_completions_(self) -> list[str]:
        return list(self.fields)

    @property
    def units(self) -> dict[str, str]:
        """The units of the fields, where they are known."""
        return {}

    def _as_table(self) -> Any:
        known = {name: values[np.isfinite(values)] if values.dtype.kind == "f" else np.empty(0) for name, values in self.fields.items()}
        return repr(self).strip("<>").partition(": ")[0], ("field", "shape", "unit", "least", "largest"), [
            (name, str(self.fields[name].shape), self.units.get(name, ""), *((one.min(), one.max()) if one.size else ("", "")))
            for name, one in known.items()]

    def _shapes(self) -> str:
        return ", ".join(f"{name} {values.shape}" for name, values in self.fields.items()) or "no fields"


def joined(parts: Sequence[N], **more: Any) -> N:
    """Returns the elements of all parts, of which there must be one or more. `more`: other fields of the dataclass."""
    arrays = {name: np.concatenate([getattr(part, name) for part in parts]) for name, values in vars(parts[0]).items()
              if isinstance(values, np.ndarray)}
    fields = {name: np.concatenate([part.fields[name] for part in parts]) for name in parts[0].fields}
    return dataclasses.replace(parts[0], fields=fields, **arrays, **more)  # type: ignore[type-var]


class Fields(Named, Mapping[str, Array]):
    """A mapping from field names to arrays."""

    def __getitem__(self, name: str) -> Array:
        return self._field(name)

    def __iter__(self) -> Iterator[str]:
        return iter(self.fields)

    def __len__(self) -> int:
        """Returns the number of fields."""
        return len(self.fields)
