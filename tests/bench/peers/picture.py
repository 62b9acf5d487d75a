"""The work-precision picture: error over cost, log-log, a panel for each body."""
from __future__ import annotations

from pathlib import Path

_RIVALS = {"odeint": "#c03028", "heyoka": "#e08020", "SciPy": "#7a5195", "MuJoCo": "#2f8f4e", "Drake": "#8c6d31",
           "Basilisk": "#5f5f5f"}
_MARKS = "os^Dv*Px"
_DASHES = ("--", ":", "-.")
_LEGEND = 2.4  # inches


def draw(data: dict, facts: dict[str, str], path: Path) -> None:
    import matplotlib
    matplotlib.use("Agg")
    from matplotlib import pyplot

    bodies = data["bodies"]
    width = 6 * len(bodies) + _LEGEND
    figure, panels = pyplot.subplots(1, len(bodies), figsize=(width, 6.4), sharey=True, squeeze=False)
    figure.subplots_adjust(left=0.7 / width, right=1 - _LEGEND / width, top=0.88, bottom=0.09, wspace=0.04)
    styles = _styles(data["contestants"])
    for axes, (body, found) in zip(panels[0], bodies.items()):
        for title, style in styles.items():
            # Before it converges an error says nothing.
            points = [p for p in found["curves"].get(title, []) if 0 < p["attitude"] < 1]
            if points:
                axes.plot([p["seconds"] for p in points], [p["attitude"] for p in points],
                          label=title.removesuffix(", compensated"), **style)
        axes.axhline(data["target"], color="black", linewidth=0.8)
        axes.set_xscale("log")
        axes.set_yscale("log")
        axes.set_ylim(1e-13, 1)
        axes.grid(alpha=0.25)
        axes.set_title(body)
        axes.set_xlabel("processor time, s")
    panels[0][0].set_ylabel(f"attitude error after {data['rotations']} rotations, rad")
    entries = {label: line for axes in panels[0] for line, label in zip(*axes.get_legend_handles_labels())}
    figure.legend(entries.values(), entries.keys(), loc="center right", fontsize=8, frameon=False)
    figure.suptitle(f"{facts['machine']}, commit {facts['commit']}\n{facts['build']}", fontsize=8)
    figure.savefig(path, dpi=130)
    pyplot.close(figure)


def _styles(contestants: list[dict]) -> dict[str, dict]:
    """Ours solid and blue, in compensated arithmetic, the default; a package's in its colour, dashed."""
    from matplotlib import colormaps

    ours = [c["title"] for c in contestants if c["package"] == "stiefel" and c["title"].endswith(", compensated")]
    blues = colormaps["YlGnBu"]
    styles = {title: {"color": blues(0.45 + 0.55 * k / max(1, len(ours) - 1)), "marker": _MARKS[k % len(_MARKS)],
                      "markersize": 3.5, "linewidth": 1.2} for k, title in enumerate(ours)}
    seen: dict[str, int] = {}
    for c in contestants:
        if c["package"] == "stiefel" or "rollout" in c["title"]:
            continue
        k = seen[c["package"]] = seen.get(c["package"], -1) + 1
        styles[c["title"]] = {"color": _RIVALS.get(c["package"], "black"), "linestyle": _DASHES[k % len(_DASHES)],
                              "marker": _MARKS[k], "markersize": 3, "linewidth": 1.4}
    return styles
