"""The pictures that the examples write."""
from __future__ import annotations

from typing import Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.legend_handler import HandlerTuple

from stiefel._results import diagram

FLOOR = 2.0**-53  # the rounding unit; smaller drifts are drawn as this value

plt.rcParams.update({
    "font.size": 11, "axes.spines.top": False, "axes.spines.right": False, "axes.grid": True,
    "grid.color": "#e2e8f0", "axes.axisbelow": True, "axes.titlesize": 11, "axes.titlelocation": "left",
    "legend.frameon": False, "figure.dpi": 100,
})


def toutatis(file: Any, run: Any, comparisons: Any, methods: dict[str, Any]) -> None:
    """Draws the body's axes, simulated (lines) and observed (dots), above the energy drift and the attitude's error of
    several methods, which are two different things."""
    figure, panels = plt.subplots(5, 1, figsize=(9, 8.6), sharex=True, layout="constrained",
                                  height_ratios=[1, 1, 1, 1.5, 1.5])
    days = run.time / 86400
    observed = np.array([comparison.observed for comparison in comparisons])
    observed_days = np.array([comparison.step for comparison in comparisons]) / 86400
    for axis, panel in enumerate(panels[:3]):
        for component in range(3):
            look = diagram.style(component)
            panel.plot(days, run["Q"][:, component, axis], lw=1.2, **diagram.line(component))
            panel.plot(observed_days, observed[:, component, axis], ls="", marker=look["marker"], color=look["color"],
                       ms=5.5, mec="white", mew=0.7)
        panel.set(ylim=(-1.15, 1.15), yticks=(-1, 0, 1), ylabel=("middle axis", "short axis", "long axis")[axis])
    panels[0].set_title("Toutatis: its axes in space, from the state of 9 November 1992")
    keys = [plt.Line2D([], [], **diagram.line(component)) for component in range(3)]
    keys.append(tuple(plt.Line2D([], [], **{**diagram.style(component), "linestyle": ""}, ms=5.5)
                      for component in range(3)))
    panels[0].legend(keys, ["x", "y", "z", "radar"], ncols=4, loc="lower right", bbox_to_anchor=(1, 0.97),
                     borderpad=0, columnspacing=1.2, handlelength=2.4, handler_map={tuple: HandlerTuple(None)})
    for k, found in enumerate(methods.values()):
        panels[3].semilogy(found.days, np.maximum(found.drift, FLOOR), label=found.method, **diagram.line(k))
        # An error too small to tell, such as that at the start, has no place on the scale.
        known = np.where(found.error > 0, found.error, np.nan)
        panels[4].semilogy(found.days, known, label=found.method, **diagram.line(k))
    panels[3].set(ylim=(FLOOR / 4, None), ylabel="relative")
    panels[3].set_title("energy drift in steps of one hour")
    panels[4].set(xlim=(0, days[-1]), xlabel="days", ylabel="degrees")
    panels[4].set_title("error of the attitude in steps of one hour: a kept energy does not make it small")
    panels[3].legend(loc="center right", bbox_to_anchor=(1, 0.5))
    diagram.save(figure, file)
    plt.close(figure)


def scene(file: Any, title: str, run: Any, name: str, drift_time: Any, drifts: dict[str, Any]) -> None:
    """Draws the entries of the field `name` over time, above the drift of each family of invariants."""
    figure, (entries, drift) = plt.subplots(2, 1, figsize=(9, 6.5), sharex=True, layout="constrained")
    for k, at in enumerate(list(np.ndindex(run[name].shape[1:]))[:9]):
        label = f"{name}[{','.join(map(str, at))}]"
        entries.plot(run.time, run[name][(slice(None), *at)], lw=1.2, label=label, **diagram.line(k))
    entries.set_title(title)
    entries.legend(loc="center left", bbox_to_anchor=(1, 0.5))
    for k, (family, values) in enumerate(drifts.items()):
        drift.semilogy(drift_time, np.maximum(values, FLOOR), label=family, **diagram.line(k))
    drift.set_title("largest drift in each family of invariants")
    drift.set(xlabel="time", ylim=(FLOOR / 4, None))
    drift.legend(loc="center left", bbox_to_anchor=(1, 0.5))
    diagram.save(figure, file)
    plt.close(figure)


def basin(file: Any, flips: Any, largest: float, moments: Any, seconds: float) -> None:
    """Draws how often each body turns over. `flips`: (initial spins about axis 3, initial spins about axis 1)."""
    figure, panel = plt.subplots(figsize=(7.6, 6.2), layout="constrained")
    image = panel.imshow(flips, origin="lower", extent=(-largest, largest, -largest, largest), cmap="viridis",
                         interpolation="nearest", rasterized=True)
    # The separatrix, on which the motion tends to the spin about the middle axis and turns over at most once.
    slope = np.sqrt(moments[0] * (moments[1] - moments[0]) / (moments[2] * (moments[2] - moments[1])))
    for sign in (-1, 1):
        panel.plot([-largest, largest], [-sign * slope * largest, sign * slope * largest], color="white", lw=0.8,
                   ls=(0, (5, 4)), label="separatrix" if sign > 0 else None)
    panel.grid(False)
    panel.set(xlabel="spin about axis 1 at the start, rad/s", ylabel="spin about axis 3 at the start, rad/s",
              xlim=(-largest, largest), ylim=(-largest, largest))
    panel.set_title(f"How often a body of moments {', '.join(f'{one:g}' for one in moments)} turns over in {seconds:g} s")
    legend = panel.legend(loc="upper right", labelcolor="white", frameon=True, framealpha=0.35, facecolor="black",
                          edgecolor="none")
    legend.set_zorder(3)
    figure.colorbar(image, ax=panel, label="changes of sign of the spin about axis 2")
    diagram.save(figure, file)
    plt.close(figure)
