"""The estimated error of a state, and of many."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Optional

import numpy as np
from numpy.typing import NDArray

from stiefel._results.base import Array, ByValue
from stiefel._results.html import Shown

__all__ = ["EstimatedError", "EstimatedErrors"]


@dataclass(frozen=True, repr=False)
class EstimatedError(Shown):
    """The estimated distance of a state from the exact motion. A drift says nothing about this error."""

    #: max |Q - Q_exact|. None without a frame and where it is too small to tell, below 2 * `reference_error`.
    attitude: Optional[float]
    #: max |M - M_exact| / max |M_exact|. None where it is too small to tell, below 2 * `reference_error`.
    momentum: Optional[float]
    angle: Optional[float]  #: in three dimensions the angle between the attitudes, in radians
    reference_error: float  #: the reference's own error, which attitude and momentum include
    reference: str  #: what the state was compared with
    work: float  #: instructions that the estimate took
    run_work: float  #: instructions that the run from step 0 takes
    missing: str  #: why both attitude and momentum are None, else ""
    member: Optional[int]  #: in an ensemble: the member with the largest error, whose numbers these are

    def __repr__(self) -> str:
        return f"<stiefel.EstimatedError: {self}>"

    def __str__(self) -> str:
        """Returns one line: "attitude 4.3e-14, momentum 4.1e-14 from Jacobi's closed form in extended precision"."""
        of = "" if self.member is None else f", of member {self.member}"
        if self.missing:
            return f"none: {self.missing}{of}"
        known = [f"{name} {value:.1e}" for name, value in (("attitude", self.attitude), ("momentum", self.momentum))
                 if value is not None]
        return f"{', '.join(known) or f'below {2 * self.reference_error:.1e}'} from {self.reference}{of}"


@dataclass(frozen=True, eq=False, repr=False)
class EstimatedErrors(ByValue):
    """The estimated errors at several times, one number each; NaN where there is none, because it is too small to tell or
    was not estimated. See `EstimatedError`."""

    time: Array
    step: NDArray[np.int64]  #: the step at or after the time, whose state was compared
    attitude: Array  #: max |Q - Q_exact|
    momentum: Array  #: max |M - M_exact| / max |M_exact|
    angle: Array  #: in radians, in three dimensions
    reference_error: Array  #: the reference's own error, which attitude and momentum include
    reference: str  #: what the states were compared with; empty where nothing was estimated
    missing: str  #: why there is no estimate at some of the times, else ""

    def _as_table(self) -> Any:
        columns = ("time", "step", "attitude", "momentum", "angle")
        return (f"estimated errors, from {self.reference or 'no reference'}", columns,
                list(zip(*(getattr(self, name).tolist() for name in columns))))

    def __repr__(self) -> str:
        largest = [f"{name} {np.nanmax(values):.1e}" for name in ("attitude", "momentum", "angle")
                   if not np.isnan(values := getattr(self, name)).all()]
        found = f"at most {', '.join(largest)}" if largest else self.missing or "too small to tell"
        return (f"<stiefel.EstimatedErrors at {len(self.time)} times: {found}\n"
                f"  from {self.reference or 'no reference'}>")
