"""What MeasureTradeoff answers, and its work-precision diagram."""
from __future__ import annotations

from dataclasses import dataclass
from statistics import median
from typing import Any, Iterator, Optional, Sequence

from stiefel.arrays import Ending, Outcome
from stiefel.v1 import tradeoff_pb2 as pb


@dataclass(frozen=True)
class Point:
    """A method with its order, arithmetic, and substeps or tolerance; its errors at the horizon."""

    method: str
    order: int
    substeps: int
    tolerance: Optional[float]
    arithmetic: str
    scalar: str
    attitude_error: Optional[float]  #: max |Q - Q_exact|, moduli; None without a frame, and where the run stopped
    momentum_error: Optional[float]  #: max |M - M_exact| / max |M_exact|; neither is below `setup.reference_error`
    drift: float  #: the worst of the invariants' over the run
    drift_of: str
    work: float  #: units: steps of the method times its weight
    cpu_seconds_per_second: tuple[float, ...]  #: of each timed run
    steps_per_second: float
    measured_steps: int
    extrapolated: bool
    below_reference: bool  #: neither was measured above `setup.reference_error`, which stands for both
    ending: Ending

    @property
    def outcome(self) -> Outcome:
        return self.ending.outcome

    @property
    def error(self) -> Optional[float]:
        """The larger of the two."""
        return max((e for e in (self.attitude_error, self.momentum_error) if e is not None), default=None)

    @property
    def family(self) -> str:
        """"variational 4, plain" or "variational 4, plain, float": what is one line of a diagram."""
        return f"{self.entry}, {self.arithmetic}" + (", float" if self.scalar == "float" else "")

    @property
    def entry(self) -> str:
        """"variational 4"."""
        return f"{self.method} {self.order}" if self.order else self.method

    @staticmethod
    def of(message: pb.TradeoffPoint) -> Point:
        method = message.method
        return Point(method.name, method.order, method.substeps,
                     method.tolerance if method.HasField("tolerance") else None, method.arithmetic,
                     message.scalar,
                     message.attitude_error if message.HasField("attitude_error") else None,
                     message.momentum_error if message.HasField("momentum_error") else None,
                     message.drift, message.drift_of, message.work, tuple(message.cpu_seconds_per_second),
                     message.steps_per_second, message.measured_steps, message.extrapolated,
                     message.below_reference, Ending.of(message.ending))


@dataclass(frozen=True)
class Tradeoff:
    """Error against cost on one scene."""

    setup: pb.TradeoffSetup  #: machine, build, reference and its error, horizon, budget, repeats
    points: tuple[Point, ...]
    front: tuple[Point, ...]  #: those that no other one beats in both work and error, the cheapest first

    @staticmethod
    def of(messages: Iterator[pb.MeasureTradeoffResponse]) -> Tradeoff:
        setup, points = pb.TradeoffSetup(), []
        front: tuple[Point, ...] = ()
        for message in messages:
            if message.HasField("setup"):
                setup = message.setup
            elif message.HasField("point"):
                points.append(Point.of(message.point))
            else:
                front = tuple(points[i] for i in message.front.points)
        return Tradeoff(setup, tuple(points), front)

    def plot(self, axes: Any = None, cost: str = "work", error: str = "error") -> Any:
        """The work-precision diagram, log-log, error over cost; the axes.

        `cost` is "work" or "time" (CPU seconds a simulated second: median, and a bar over the
        repeats); `error` "error", "attitude_error", "momentum_error" or "drift". The front is grey, the
        reference's error dotted.
        """
        import matplotlib.pyplot as plt  # only those who want a picture need it

        if cost not in ("work", "time"):
            raise ValueError(f'cost: {cost!r}: must be "work" or "time"')
        if axes is None:
            _, axes = plt.subplots(figsize=(11, 6), layout="constrained")
        known = self.setup.reference_error
        families: dict[str, list[Point]] = {}
        for point in self.points:
            if getattr(point, error) is not None and point.outcome == Outcome.REACHED:
                families.setdefault(point.family, []).append(point)
        colours = _colours(self.points)
        named = set()
        for points in families.values():
            first = points[0]
            colour = colours[first.entry]
            y = [max(getattr(p, error), known) for p in points]
            x = [p.work if cost == "work" else median(p.cpu_seconds_per_second) for p in points]
            style = ":" if first.scalar == "float" else "--" if first.arithmetic == "plain" else "-"
            axes.plot(x, y, style, color=colour, lw=1)
            for p, a, b in zip(points, x, y):
                axes.plot(a, b, "o", ms=4, color=colour, mfc="white" if p.extrapolated else colour)
                if cost == "time":
                    axes.plot([min(p.cpu_seconds_per_second), max(p.cpu_seconds_per_second)], [b, b],
                              color=colour, lw=1)
            if first.entry not in named:
                axes.plot([], [], "o-", color=colour, ms=4, lw=1, label=first.entry)
                named.add(first.entry)
        if cost == "work" and error == "error":
            axes.plot([p.work for p in self.front], [max(p.error or 0.0, known) for p in self.front], color="0.8",
                      lw=6, zorder=0, solid_capstyle="round")
        if error != "drift":
            axes.axhline(known, color="0.4", ls=":", lw=1)
        axes.set(xscale="log", yscale="log", ylabel=error.replace("_", " ") + " at the horizon",
                 xlabel="work, instructions" if cost == "work" else "CPU seconds a simulated second")
        axes.set_title(f"horizon {self.setup.horizon:g}, {self.setup.steps} steps; {self.setup.repeats} timed runs "
                       f"a point\n{self.setup.machine}\n{self.setup.build.split(', glibc')[0]}", fontsize=8, loc="left")
        axes.plot([], [], "k--", lw=1, label="plain arithmetic")
        if any(point.scalar == "float" for point in self.points):
            axes.plot([], [], "k:", lw=1, label="float")
        axes.plot([], [], "ko", ms=4, mfc="white", label="extrapolated")
        axes.legend(fontsize=8, frameon=False, loc="upper left", bbox_to_anchor=(1.01, 1), borderaxespad=0)
        return axes


def _colours(points: Sequence[Point]) -> dict[str, Any]:
    """A hue for each method, the deeper the higher the order; black for a closed form."""
    import matplotlib.pyplot as plt

    orders: dict[str, set[int]] = {}
    for p in points:
        orders.setdefault(p.method, set()).add(p.order)
    colours: dict[str, Any] = {}
    hues = iter(range(len(orders)))
    for method, of in orders.items():
        if of == {0}:
            colours[method] = (0, 0, 0)
            continue
        hue = plt.get_cmap("tab10")(next(hues) % 10)[:3]
        for place, order in enumerate(sorted(of, reverse=True)):
            white = 0.65 * place / len(of)
            colours[f"{method} {order}"] = tuple(c + (1 - c) * white for c in hue)
    return colours
