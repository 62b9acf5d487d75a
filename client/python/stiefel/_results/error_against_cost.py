"""Error against cost on a scene, and its work-precision diagram."""
from __future__ import annotations

import math
from dataclasses import dataclass, fields
from statistics import median
from typing import Any, Optional

import numpy as np

from stiefel._results import diagram
from stiefel._results.base import Ended, RunStatus
from stiefel._results.extras import imported
from stiefel._results.html import Shown

__all__ = ["Point", "Tradeoff"]


@dataclass(frozen=True)
class Point(Ended):
    """A method with its order, arithmetic, and substeps or tolerance, and its errors and cost."""

    method: str
    order: int
    substeps: int
    tolerance: Optional[float]
    arithmetic: str
    scalar: str
    #: max |Q - Q_exact| at the horizon, with moduli for complex Q, at least `Tradeoff.reference_error`. None without a
    #: frame and where the run stopped.
    attitude_error: Optional[float]
    #: max |M - M_exact| / max |M_exact| at the horizon, at least `Tradeoff.reference_error`. None where the run stopped.
    momentum_error: Optional[float]
    drift: float  #: the worst drift of an invariant at up to 58 steps of the run
    drift_of: str  #: the invariant with the worst drift
    work: float  #: instructions to the horizon: steps of the method times the work of one step
    cpu_seconds_per_second: tuple[float, ...]  #: CPU seconds per simulated second, one number for each timed run
    steps_per_second: float  #: in the median of the timed runs
    measured_steps: int  #: fewer than the steps to the horizon if `extrapolated`
    extrapolated: bool
    below_reference: bool  #: no error was measured above `Tradeoff.reference_error`, so that both are reported as that
    run_status: RunStatus

    @property
    def error(self) -> Optional[float]:
        """The larger of attitude and momentum error; None if there is neither."""
        return max((e for e in (self.attitude_error, self.momentum_error) if e is not None), default=None)

    @property
    def family(self) -> str:
        """The name of the point's curve in a diagram: "variational 4, plain" or "variational 4, plain, float"."""
        return f"{self.entry}, {self.arithmetic}" + (", float" if self.scalar == "float" else "")

    @property
    def entry(self) -> str:
        """The method with its order: "variational 4"."""
        return f"{self.method} {self.order}" if self.order else self.method


@dataclass(frozen=True, repr=False)
class Tradeoff(Shown):
    """Error against cost on one scene."""

    points: tuple[Point, ...]
    front: tuple[Point, ...]  #: the points that no other one beats in both work and error, the cheapest first
    horizon: float
    steps: int  #: to the horizon
    reference: str  #: what the points were compared with
    reference_steps: int  #: that the reference took
    reference_error: float
    machine: str
    numerics_id: str  #: of the build
    budget: float  #: instructions that the measurement may take
    repeats: int  #: timed runs of a point
    warnings: tuple[str, ...]

    def _as_table(self) -> Any:
        return ("Pareto front, the cheapest first", ("method", "arithmetic", "substeps", "error", "work", "drift"),
                [(p.entry, p.arithmetic, p.substeps, p.error, p.work, p.drift) for p in self.front])

    def __repr__(self) -> str:
        """Returns three lines, with the ends of the Pareto front."""
        lines = [f"<stiefel.Tradeoff of {len(self.points)} points, {len(self.front)} of them on the Pareto front, horizon "
                 f"{self.horizon:g}, reference error {self.reference_error:.0e}"]
        for what, ends in (("cheapest", self.front[:1]), ("most accurate", self.front[-1:])):
            lines += [f"  {what}: {p.family}, {p.substeps} substeps: error {p.error:.1e}, work {p.work:.1e}"
                      for p in ends if p.error is not None]
        return "\n".join(lines) + ">"

    def _rows(self) -> list[dict[str, Any]]:
        return [{**{field.name: getattr(p, field.name) for field in fields(p) if field.name != "run_status"}, "error": p.error,
                 "cpu_seconds_per_second": median(p.cpu_seconds_per_second or (math.nan,)), "front": p in self.front,
                 "outcome": str(p.outcome)} for p in self.points]

    def to_dataframe(self) -> Any:
        """Returns a `pandas.DataFrame` with a row for each point, whose `front` tells whether it is on the Pareto front, and
        `cpu_seconds_per_second` the median; `to_latex` and others of pandas write it. `attrs` has horizon, reference error and
        machine."""
        frame = imported("pandas", "pandas").DataFrame(self._rows()).astype({name: float for name in ("tolerance", "attitude_error", "momentum_error", "error")})
        frame.attrs.update({name: getattr(self, name) for name in ("horizon", "reference_error", "machine", "numerics_id")})
        return frame

    def plot(self, axes: Any = None, *, cost: str = "work", error: str = "error") -> Any:
        """Plots the work-precision diagram, error over cost in logarithmic scales, and returns the axes.

        `axes`: the matplotlib axes to use; new ones by default. `cost`: "work" or "time" (CPU seconds per simulated
        second, the median with a bar over the repeats). `error`: "error" (the larger of attitude and momentum error),
        "attitude_error", "momentum_error" or "drift". The Pareto front is drawn in black on top. Of each method
        the order and arithmetic with the point of the smallest product of cost and error is a coloured curve; all other curves
        are grey. Needs matplotlib: stiefel[plot].
        """
        if cost not in ("work", "time"):
            raise ValueError(f'cost: {cost!r}: must be "work" or "time"')
        if axes is None:
            _, axes = imported("matplotlib.pyplot", "plot").subplots(figsize=(11, 6.5), layout="constrained")
        known = self.reference_error
        families: dict[str, list[tuple[float, float, Point]]] = {}  # cost, error
        for point in self.points:
            if (value := getattr(point, error)) is not None and point.success:
                x = point.work if cost == "work" else median(point.cpu_seconds_per_second)
                families.setdefault(point.family, []).append((x, max(value, known), point))
        front = diagram.pareto_front(one[:2] for curve in families.values() for one in curve)
        best: dict[str, str] = {}
        for name in sorted(families, key=lambda name: min(x * y for x, y, _ in families[name])):
            best.setdefault(families[name][0][2].method, name)
        named = [*best.values()]
        for name, curve in families.items():
            look = {"color": diagram.GREY, "lw": 0.8, "marker": "o", "ms": 2.5, "zorder": 1} if name not in named else \
                {**diagram.style(named.index(name)), "lw": 1.4, "ms": 5, "zorder": 4, "label": name}
            x, y = np.transpose([one[:2] for one in curve])
            hollow = [one.extrapolated for *_, one in curve]
            axes.plot(x, y, **look)
            axes.plot(x[hollow], y[hollow], **{**look, "linestyle": "", "mfc": "white", "label": None})
            if cost == "time":
                ends = np.transpose([(min(one.cpu_seconds_per_second), max(one.cpu_seconds_per_second)) for *_, one in curve])
                axes.hlines(y, *ends, color=look["color"], lw=look["lw"])
        if front:
            axes.plot(*zip(*front), color="black", lw=2.5, marker="o", ms=9, mfc="none", mew=1.5, zorder=6,
                      label="Pareto front: no point beats these in both")
        axes.plot([], [], color=diagram.GREY, marker="o", ms=3, lw=0.8, label="other orders and arithmetics")
        axes.plot([], [], "ko", ms=5, mfc="white", label="extrapolated")
        if error != "drift" and any(y <= known for curve in families.values() for _, y, _ in curve):
            axes.axhline(known, color="0.4", ls=":", lw=1, label="error of the reference")
        axes.set(xscale="log", yscale="log", ylabel=error.replace("_", " ") + " at the horizon",
                 xlabel="work, instructions" if cost == "work" else "CPU seconds a simulated second")
        axes.set_title(f"horizon {self.horizon:g}, {self.steps} steps; {self.repeats} timed runs a point; error of the reference "
                       f"{known:.0e}\n{self.machine}\nstiefel, numerics id {self.numerics_id}", fontsize=8, loc="left")
        axes.legend(fontsize=8, loc="center left", bbox_to_anchor=(1, 0.5), frameon=False)
        return axes
