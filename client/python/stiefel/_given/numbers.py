"""Numbers that a caller gives: plain, of numpy, or with units; alone, or in the shapes of one motion or of an ensemble. Errors name
the argument, its value and the rule."""
from __future__ import annotations

import datetime
import itertools
import math
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from typing import Any, Mapping, Optional

import numpy as np
from numpy.typing import NDArray

from stiefel._given.shown import shown
from stiefel.errors import InvalidArgument, Violation

SECONDS = "s"
_REAL = {int, float, np.float64, np.float32, np.int64, np.int32}
_NO_NUMBERS = (bool, np.bool_, str, bytes, datetime.date, datetime.time, type(None))


def refused(path: str, description: str) -> InvalidArgument:
    """Returns the exception for one wrong value. `description`: the value and the rule that it breaks."""
    return InvalidArgument(f"{path}: {description}", (Violation(path, description),))


def numbers(path: str, given: Any, unit: str = "", may_be_complex: bool = False, what: str = "numbers") -> NDArray[Any]:
    """Returns numbers as an array of the shape given. `unit`: that of the numbers, such as "rad/s"; "" for none. `what`:
    what errors call them.

    A quantity (of astropy, pint, or any library whose quantities convert themselves) becomes numbers in `unit`. A
    timedelta of Python, numpy or pandas becomes seconds. Raises InvalidArgument for everything else that is not a
    number: truth values, texts, dates, complex numbers unless `may_be_complex`, masked elements, other units.
    """
    if isinstance(given, datetime.timedelta):
        return _seconds(path, given, given.total_seconds(), unit)
    if isinstance(given, (list, tuple)) and not _are_real(given):
        parts = [numbers(path, part, unit, may_be_complex, what) for part in given]
        if len({part.shape for part in parts}) > 1:
            raise refused(path, f"{shown(given)}: must be {what}, its rows of one length")
        return np.array(parts)
    if _has_unit(given):
        given = _converted(path, given, unit, what)
    return _of_array(path, given, unit, may_be_complex, what)


def number(path: str, given: Any, unit: str = "") -> float:
    """Returns one number as `numbers` does."""
    value = numbers(path, given, unit)
    if value.ndim:
        raise refused(path, f"{shown(given)}: must be one number")
    return float(value)


def optional(path: str, given: Any, unit: str = "") -> Optional[float]:
    """Returns one number, or None for None."""
    return None if given is None else number(path, given, unit)


def whole(path: str, given: Any, least: int = 0, hint: str = "", bits: int = 63) -> int:
    """Returns a whole number of any type, 30.0 too, that travels in `bits` bits. `hint`: what to say besides of a number that is
    not whole."""
    array = isinstance(given, (np.ndarray, np.generic)) and given.ndim == 0
    value = given.item() if array and not _has_unit(given) else given
    if isinstance(value, (float, Decimal, Fraction)):
        is_whole = math.isfinite(value) and value == int(value)
    else:
        is_whole = (hasattr(value, "__index__") and not isinstance(value, (bool, np.ndarray)) and not _has_unit(value))
    if is_whole and least <= int(value) < 2**bits:
        return int(value)
    above = f" and below 2^{bits}" if is_whole and int(value) > least else ""
    raise refused(path, f"{shown(given)}: must be a whole number of at least {least}{above if is_whole else hint}")


def step_index(path: str, given: Any, least: int = 0) -> int:
    """Returns the index of a step, or a number of steps."""
    if least == 0 and type(given) in _REAL and given < 0:
        raise refused(path, f"{shown(given)}: must be a whole number of at least 0; for times before 0, use a negative step "
                            "in the scene, or `times` of Session.trajectory")
    return whole(path, given, least, ", because it counts steps; for states between steps, use `time`, or `times` of Session.trajectory")


def text(path: str, given: Any) -> str:
    """Returns a text, such as the id of a session."""
    if not isinstance(given, str):
        raise refused(path, f"{shown(given)}: must be a text")
    return given


def timeout(given: Any) -> Optional[float]:
    """Returns seconds; None for no end, which infinitely many seconds mean too."""
    seconds = optional("timeout", given, SECONDS)
    if seconds is not None and not seconds >= 0:
        raise refused("timeout", f"{shown(given)}: must be at least 0 seconds, or None")
    return None if seconds == math.inf else seconds


@dataclass
class Ensemble:
    """The number of members, None for a single motion, and the shape of one member's blocks where it is known."""

    members: Optional[int] = None
    rows: Optional[int] = None
    cols: Optional[int] = None
    wrong: bool = False  #: whether the number of members is none, so that no shape fits and the number itself is refused

    @staticmethod
    def of(members: Any) -> Ensemble:
        """`members`: the field of a scene, which may be a text as in JSON."""
        try:
            return Ensemble(whole("members", int(members) if isinstance(members, str) else members, 1))
        except ValueError:  # InvalidArgument is one
            return Ensemble(wrong=True)

    def see(self, block: Any) -> None:
        """Takes the shape of a block, an array or a Matrix as a mapping, if none is known."""
        shape: Any = (block.get("rows"), block.get("cols")) if isinstance(block, Mapping) else block.shape
        if self.rows is None and isinstance(shape[-2], int) and isinstance(shape[-1], int):
            self.rows, self.cols = shape[-2] // (self.members or 1) if len(shape) == 2 else shape[1], shape[-1]

    def each(self, count: str) -> Optional[int]:
        """Returns how many numbers of a list are one member's; None where that is not known."""
        return int(count) if count.isdigit() else getattr(self, count, None)


def list_of(place: str, given: Any, unit: str, count: str, ensemble: Ensemble, strict: bool = False,
            may_be_matrix: bool = False) -> NDArray[Any]:
    """Returns a list of numbers. One that all members share has the shape (numbers), one of each member's own (members, numbers). A
    list of Python's may also be flat, as in a scene file: one member after another. Raises InvalidArgument for any other shape.

    `count`: how many numbers are one motion's, as the protocol says it; "" for those of a list in whatever shape, such as the
    coefficients of a field. `strict`: refuses another number here, which else the server does. `may_be_matrix`: takes the shapes
    (3, 3) and (members, 3, 3) too.
    """
    array, members, each = numbers(place, given, unit), ensemble.members, ensemble.each(count)
    if not count:
        return array
    is_flat = members is not None and members > 1 and each is not None and array.shape == (members * each,)
    if array.ndim == 1:
        fits = isinstance(given, (list, tuple)) if is_flat else not strict or array.shape == (each,)
    else:
        fits = members is not None and array.ndim == 2 and array.shape == (members, each or array.shape[1])
    if not (fits or ensemble.wrong or may_be_matrix and array.shape in ((3, 3), (members, 3, 3))):
        one = [f"({each or 'numbers'})"] + ["(3, 3)"] * may_be_matrix
        own = [] if members is None else [f"({members}, {shape[1:]}" for shape in one]
        what = shown(given) if isinstance(given, (int, float)) else f"the shape {array.shape}"
        raise refused(place, f"{what}: must be {' or '.join(one + own)}")
    return array.reshape(members or 1, -1) if is_flat else array


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


def _are_real(given: Any) -> bool:
    """Returns whether a list, or nested lists whose rows have one length, have plain numbers alone."""
    kinds = set(map(type, given))
    return kinds <= _REAL or (kinds <= {list, tuple} and len(set(map(len, given))) == 1
                              and _are_real(list(itertools.chain.from_iterable(given))))


def _of_array(path: str, given: Any, unit: str, may_be_complex: bool, what: str) -> NDArray[Any]:
    if isinstance(given, _NO_NUMBERS) or np.ma.is_masked(given):
        raise _wrong(path, given, unit, what)
    try:
        array = np.asarray(given)
    except ValueError:
        raise _wrong(path, given, unit, what) from None
    kind = array.dtype.kind
    if kind == "m" and np.datetime_data(array.dtype)[0] not in ("generic", "M", "Y"):
        return _seconds(path, given, array / np.timedelta64(1, "s"), unit)
    if kind == "O" and array.ndim and not isinstance(given, (list, tuple)):
        return numbers(path, array.tolist(), unit, may_be_complex, what)
    try:
        if kind in "iufO":
            return array.astype(float)
    except (TypeError, ValueError, OverflowError):
        pass
    if kind == "c" and may_be_complex:
        return array.astype(complex)
    raise _wrong(path, given, unit, what)


def _has_unit(given: Any) -> bool:
    """Returns whether the numbers carry a unit. A time of pandas has a `unit`, too, but that is its resolution."""
    if isinstance(given, _NO_NUMBERS) or getattr(getattr(given, "dtype", None), "kind", "") in ("m", "M"):
        return False
    return any(hasattr(given, name) for name in ("unit", "units", "sec"))  # `sec`: a TimeDelta of astropy


def _converted(path: str, given: Any, unit: str, what: str) -> Any:
    """Returns the numbers of a quantity in `unit`."""
    convert = getattr(given, "to", None) or getattr(given, "rescale", None)
    try:
        inside = convert(unit)  # type: ignore[misc]
        return inside.magnitude if hasattr(inside, "magnitude") else inside.value
    except Exception:  # each library raises its own
        raise _wrong(path, given, unit, what) from None


def _seconds(path: str, given: Any, seconds: Any, unit: str) -> NDArray[Any]:
    if unit != SECONDS:
        raise _wrong(path, given, unit)
    return np.asarray(seconds, float)


def _wrong(path: str, given: Any, unit: str, what: str = "numbers") -> InvalidArgument:
    without = f"must be {what} without a unit" if _has_unit(given) else f"must be {what}"
    rules = {"": without, SECONDS: "must be numbers of seconds, a timedelta or a quantity of time"}
    return refused(path, f"{shown(given)}: {rules.get(unit, f'must be numbers in {unit}, or a quantity that converts to it')}")
