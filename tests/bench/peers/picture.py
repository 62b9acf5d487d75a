"""Draws the work-precision picture: error over cost in logarithmic scales, with a panel for each body.

The best curve of each of our methods (solid) and of each package (dashed) is in the legend; all other orders, arithmetics and
settings are grey. The Pareto front, the points that no other one beats, is black and on top.
"""
from __future__ import annotations

from pathlib import Path
from typing import Any

from stiefel._results import diagram

_Curve = list[tuple[float, float]]  # seconds, error


def draw(data: dict, facts: dict[str, str], path: Path) -> None:
    import matplotlib
    matplotlib.use("Agg")
    from matplotlib import pyplot

    bodies = data["bodies"]
    figure, panels = pyplot.subplots(1, len(bodies), figsize=(8 * len(bodies), 6.8), sharey=True, squeeze=False,
                                     layout="constrained")
    families = _families(data["contestants"])
    looks = _looks(data["contestants"], families)
    for axes, (body, found) in zip(panels[0], bodies.items()):
        # Errors before convergence are left out.
        curves = {title: points for title in families
                  if (points := [(p["seconds"], p["attitude"]) for p in found["curves"].get(title, [])
                                 if 0 < p["attitude"] < 1])}
        axes.axhline(data["target"], color="black", linewidth=0.8)
        axes.set(xscale="log", yscale="log", ylim=(1e-13, 1), title=body, xlabel="processor time, s")
        _panel(axes, curves, families, looks)
        axes.legend(fontsize=8, loc="upper right", framealpha=0.9, edgecolor="none")
    panels[0][0].set_ylabel(f"attitude error after {data['rotations']} rotations, rad")
    figure.suptitle(f"{facts['machine']}, commit {facts['commit']}\n{facts['build']}", fontsize=8)
    figure.savefig(path, dpi=95)
    pyplot.close(figure)


def _families(contestants: list[dict]) -> dict[str, str]:
    """Returns the family of each contestant by its title: the name of our method, or the package."""
    return {c["title"]: c["title"].split()[0].rstrip(",") if c["package"] == "stiefel" else c["package"]
            for c in contestants if "rollout" not in c["title"]}


def _looks(contestants: list[dict], families: dict[str, str]) -> dict[str, dict]:
    """Returns the style of each family, with marks and colours as in the client's diagrams."""
    ours = {families[c["title"]] for c in contestants if c["package"] == "stiefel" and c["title"] in families}
    return {family: {**diagram.style(k), "linestyle": "-" if family in ours else (0, (4, 1.5))}
            for k, family in enumerate(dict.fromkeys(families.values()))}


def _panel(axes: Any, curves: dict[str, _Curve], families: dict[str, str], looks: dict[str, dict]) -> None:
    """Draws a panel."""
    everywhere = [point for points in curves.values() for point in points]
    corner = (2 * max((x for x, _ in everywhere), default=1), 1)
    best: dict[str, tuple[float, str]] = {}
    for title, points in curves.items():
        found = diagram.dominated_area(points, corner), title
        best[families[title]] = max(best.get(families[title], found), found, key=lambda f: f[0])
    named = [title for _, title in best.values()]
    for title, points in curves.items():
        if title in named:
            axes.plot(*zip(*points), markersize=4, linewidth=1.4, zorder=4, label=title.removesuffix(", compensated"), **looks[families[title]])
        else:
            axes.plot(*zip(*points), color=diagram.GREY, linewidth=0.8, marker="o", markersize=2, zorder=1)
    if front := diagram.pareto_front(everywhere):
        axes.plot(*zip(*front), color="black", lw=2, marker="o", ms=7, mfc="none", mew=1.2, zorder=6,
                  label="Pareto front: no point beats these in both")
    axes.plot([], [], color=diagram.GREY, lw=0.8, label="other orders and settings")
    axes.grid(alpha=0.25)
