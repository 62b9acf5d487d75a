"""What a run is reduced to on the server: events, statistics, and the derivative of the computed steps."""
from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Iterator, Mapping, Optional, TypeVar, overload

import numpy as np
from numpy.typing import NDArray

from stiefel._given.numbers import numbers
from stiefel._results import diagram
from stiefel._results.base import Array, ByValue, Ended, Named, RunStatus, Word
from stiefel._results.extras import imported
from stiefel._results.html import ROWS
from stiefel._results.tables import flat

__all__ = ["Events", "LyapunovSpectrum", "Section", "StateTransition", "Summary", "Verdict"]
E = TypeVar("E", bound="Events")


@dataclass(frozen=True, eq=False, repr=False)
class Events(Named):
    """Zeros of functions of the state, ordered by step. `events["Q"]` is a field at all zeros, `len` the number of zeros,
    and `events[a:b:c]` has those of a slice. Events are equal if all their arrays and their run statuses are equal."""

    event: NDArray[np.uint32]  #: the index of the event among those asked for
    step: NDArray[np.int64]  #: the last step before the zero
    #: The zero is at step + fraction, 0 < fraction <= 1. For a discrete system the fraction is 1, and the zero lies
    #: somewhere between the two steps.
    fraction: Array
    time: Array  #: (step + fraction) times the scene's step
    member: Optional[NDArray[np.uint32]]  #: the member of an ensemble; None for a single motion
    fields: dict[str, Array]  #: the fields at the zeros: (events, rows, cols), a vector (events, n), a number (events,)
    run_status: Optional[RunStatus] = None  #: how the run ended; None in the parts from `Session.stream_events`

    @property
    def count(self) -> int:
        """The number of zeros."""
        return len(self.step)

    def __len__(self) -> int:
        """Returns the number of zeros."""
        return len(self.step)

    @overload
    def __getitem__(self, which: str) -> Array: ...

    @overload
    def __getitem__(self: E, which: slice) -> E: ...

    def __getitem__(self, which: Any) -> Any:
        return self._slice(which) if isinstance(which, slice) else self._field(which)

    def __iter__(self) -> Iterator[Events]:
        """Yields each zero as events of length 1."""
        return (self[k:k + 1] for k in range(len(self)))

    def to_dataframe(self) -> Any:
        """Returns a `pandas.DataFrame` with a row for each zero: event, step, fraction, time, in an ensemble member, and a column
        for each number of the fields; of a section also point[0], point[1], ... and residual."""
        return imported("pandas", "pandas").DataFrame({name: np.ascontiguousarray(values) for name, values in self._columns().items()})

    def _columns(self) -> dict[str, Array]:
        found: dict[str, Any] = {name: getattr(self, name) for name in ("event", "step", "fraction", "time")}
        return {**found, **({} if self.member is None else {"member": self.member}), **flat(self.fields)}

    def __repr__(self) -> str:
        outcome = f" {self.run_status.outcome}" if self.run_status else ""
        return f"<stiefel.Events{outcome} of {self.count} zero{'s' if self.count != 1 else ''}: {self._shapes()}>"


@dataclass(frozen=True, eq=False, repr=False)
class Section(Events):
    """The crossings of a plane in the space of states, from `Session.poincare`, ordered by step."""

    points: Array = field(default_factory=lambda: np.empty((0, 0)))  #: (crossings, coordinates)
    residual: Array = field(default_factory=lambda: np.empty(0))  #: how far the reported state is from the plane: g at the crossing

    def _columns(self) -> dict[str, Array]:
        points = {f"point[{k}]": values for k, values in enumerate(self.points.T)}
        return {**super()._columns(), **points, "residual": self.residual}

    def _as_table(self) -> Any:
        columns = [values[:ROWS].tolist() for values in (self.step, self.time, *self.points.T, self.residual)]
        names = ["step", "time", *(f"point[{k}]" for k in range(self.points.shape[1])), "residual"]
        left = f", the first {ROWS} of them" if self.count > ROWS else ""
        return f"{self.count} crossing{'s' * (self.count != 1)}{left}", names, list(zip(*columns))

    def plot(self, axes: Any = None, *, x: int = 0, y: int = 1, **look: Any) -> Any:
        """Draws column `y` of `points` over column `x`, each member of an ensemble in a colour of its own, and returns the axes.

        `axes`: the matplotlib axes to use; new ones by default. `look`: what its `plot` takes, such as `markersize`. Raises
        ValueError where `poincare` was not asked for such coordinates. Needs matplotlib: stiefel[plot].
        """
        columns = self.points.shape[-1]
        if not (0 <= x < columns and 0 <= y < columns):
            raise ValueError(f"x, y: {x}, {y}: must be columns of points, of which there are {columns}: give `coordinates` to poincare")
        axes = imported("matplotlib.pyplot", "plot").subplots(layout="constrained")[1] if axes is None else axes
        members = np.zeros(len(self)) if self.member is None else self.member
        for member in np.unique(members):
            axes.plot(*self.points[members == member][:, [x, y]].T, **{"ls": "", "marker": ".", "markersize": 2.0, **look})
        return axes

    def __repr__(self) -> str:
        return super().__repr__().replace("Events", "Section").replace(" zero", " crossing")


@dataclass(frozen=True, eq=False, repr=False)
class StateTransition(Ended, ByValue):
    """The derivative of the computed steps, from `Session.linearize`.

    Column k of `matrix`, (d, m), is what became of vector k, in the coordinates at `step`; behind these columns stand
    those of the `parameters`. With `every` the results stand along a first axis of `step`, `time`, `matrix`, `vectors`
    and `basis`.

    Coordinates of a body (Q, M): eta, then dM, with dQ = Q eta; for N = 3 as axial
    vectors (x, y, z), otherwise the elements i < j row by row. Of other states: those of the orthonormal `basis`, which with
    "inertia" among the `parameters` has n (n + 1) / 2 elements behind the tangent space of a (Q, S).
    """

    step: Any  #: the step, or (results,) the steps
    time: Any  #: in seconds
    matrix: Optional[Array]  #: (d, m); None where the vectors were given as blocks
    vectors: Optional[Array]  #: (m, rows, cols), where they were given as blocks
    basis: Optional[Array]  #: (d, rows, cols): element k is the vector with the coordinate k equal to 1, blocks stacked
    start_basis: Optional[Array]  #: the same at the state where the vectors start
    parameters: tuple[str, ...]  #: "inertia", with a column for each lambda; "step", with one
    run_status: RunStatus
    computed_steps: int = field(default=0, compare=False)
    work: float = field(default=0.0, compare=False)  #: measured instructions

    def gradient(self, slope: Any) -> Array:
        """Returns the derivatives of a scalar of the last state by the start's coordinates and by the parameters, in the
        order of the columns. `slope`: the derivatives of the scalar by the last state's coordinates, (d)."""
        if self.matrix is None:
            raise TypeError("the vectors were given as blocks: their matrix is not known")
        last = self.matrix if self.matrix.ndim == 2 else self.matrix[-1]
        return np.asarray(numbers("slope", slope) @ last)


class Verdict(Word):
    """What the growth of tangent vectors says of a motion."""

    UNDECIDED = "undecided"
    REGULAR = "regular"
    CHAOTIC = "chaotic"


@dataclass(frozen=True, eq=False, repr=False)
class LyapunovSpectrum(Ended, ByValue):
    """Lyapunov exponents, from `Session.lyapunov`: how fast neighbouring motions part.

    A tangent vector (dQ, dM) is measured by |dQ|^2 + n |dM|^2 / |M|^2, with the norms of the blocks at the start.
    t lambda(t) grows like ln t where a motion is regular, and in proportion to t where it is chaotic.
    """

    exponents: Array  #: (k,), in 1/time, in the order of the vectors: the largest first, up to the errors
    errors: Array  #: (k,), half-widths of 95 % intervals: batch means, and what growth by a factor t contributes
    verdict: Verdict
    reason: str  #: why, in words and numbers
    log_gali: Array  #: (k - 1,), ln GALI_2 ... ln GALI_k, which have no floor
    step: int  #: where the exponents end
    time: float
    steps: Array  #: (r,), of the numbers on the way, the last ones included
    times: Array  #: (r,), from step 0 of the scene
    history: Array  #: (r, k), exponents over the time from the start to there
    log_gali_history: Array  #: (r, k - 1)
    interval: int  #: steps between two orthonormalisations
    run_status: RunStatus
    checkpoint: bytes = field(default=b"", compare=False)  #: from which a later call goes on
    computed_steps: int = field(default=0, compare=False)
    work: float = field(default=0.0, compare=False)  #: measured instructions

    @property
    def gali(self) -> Array:
        """GALI_2 ... GALI_k: the volumes of the first j vectors, each of length 1 but not orthonormalised."""
        return np.asarray(np.exp(self.log_gali))

    def plot(self, axes: Any = None) -> Any:
        """Draws the exponents over the time from the start, the `history` that `every` keeps, with the error bars of the last,
        and returns the axes. `axes`: the matplotlib axes to use; new ones by default. Needs matplotlib: stiefel[plot]."""
        axes = imported("matplotlib.pyplot", "plot").subplots(layout="constrained")[1] if axes is None else axes
        for k, values in enumerate(self.history.T):
            axes.errorbar(self.times[-1:], values[-1:], self.errors[k:k + 1], color=diagram.COLOURS[k % len(diagram.COLOURS)], capsize=3)
            axes.plot(self.times, values, label=f"$\\lambda_{{{k + 1}}}$", **diagram.line(k))
        axes.axhline(0, color="0.6", lw=0.8, zorder=0)
        axes.set(xscale="log", xlabel="time", ylabel="exponent, 1/time")
        axes.set_title(str(self.verdict), loc="left")
        if 0 < len(self.exponents) <= 12:
            axes.legend(fontsize="small")
        return axes

    def __repr__(self) -> str:
        largest = f", largest exponent {self.exponents[0]:.3g}" if len(self.exponents) else ""
        error = f" +- {self.errors[0]:.2g}" if len(self.errors) else ""
        return f"<stiefel.LyapunovSpectrum {self.verdict}{largest}{error}>"


@dataclass(frozen=True, eq=False, repr=False)
class Summary(Ended, ByValue, Mapping[str, "dict[str, Array]"]):
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
    work: float = field(default=0.0, compare=False)  #: measured instructions
    checkpoint: bytes = field(default=b"", compare=False)  #: the last checkpoint, if any was asked for

    def __getitem__(self, name: str) -> dict[str, Array]:
        try:
            return self.quantities[name]
        except KeyError:
            raise KeyError(f"no quantity {name!r}; the quantities are {', '.join(self.quantities) or 'none'}") from None

    def _ipython_key_completions_(self) -> list[str]:
        return list(self.quantities)

    def __iter__(self) -> Any:
        return iter(self.quantities)

    def __len__(self) -> int:
        return len(self.quantities)

    def _as_table(self) -> Any:
        return (f"{self.outcome}", ("quantity", "statistic", "value"),
                [(name, statistic, values) for name, found in self.quantities.items() for statistic, values in found.items()])

    def __repr__(self) -> str:
        what = ", ".join(f"{name} {'/'.join(statistics)}" for name, statistics in self.quantities.items())
        return f"<stiefel.Summary {self.outcome}: {what or 'nothing'}>"
