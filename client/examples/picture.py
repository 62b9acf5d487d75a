"""The picture of toutatis.py. Curves differ in colour and in dashes, so that they can be told apart in grey."""
from __future__ import annotations

from typing import Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from cycler import cycler

FLOOR = 2.0**-53  # the rounding unit; smaller drifts are drawn as this value

plt.rcParams.update({
    "font.size": 11, "axes.spines.top": False, "axes.spines.right": False, "axes.grid": True,
    "grid.color": "#e2e8f0", "axes.axisbelow": True, "axes.titlesize": 11, "axes.titlelocation": "left",
    "legend.frameon": False, "figure.dpi": 100,
    "axes.prop_cycle": cycler(color=["#0072B2", "#D55E00", "#009E73"]) + cycler(linestyle=["-", "--", "-."]),
})


def toutatis(file: Any, run: Any, comparisons: Any, methods: dict[str, Any]) -> None:
    """Draws rates and spin axis, the angles to the observed axes, and the energy drift and the attitude's error of several
    methods, which are two different things, below each other over one axis of time, and the polhode beside them."""
    figure = run.plot(("rates", "spin_axis", "polhode"), figure=plt.figure(figsize=(11.5, 9), layout="constrained"))
    figure.suptitle("Toutatis from the state of 9 November 1992", x=0.01, ha="left")
    rates, spin_axis, polhode = figure.axes
    grid = figure.add_gridspec(5, 2, width_ratios=[2.1, 1])
    observed, drift, error = (figure.add_subplot(grid[row, 0], sharex=rates) for row in (2, 3, 4))
    for panel, place in ((rates, grid[0, 0]), (spin_axis, grid[1, 0]), (polhode, grid[:3, 1])):
        panel.set_subplotspec(place)
    error.set_xlabel(spin_axis.get_xlabel())
    spin_axis.set_xlabel("")
    for panel in (spin_axis, observed, drift):
        panel.tick_params(labelbottom=False)
    times = np.array([comparison.step for comparison in comparisons])
    angles = np.array([comparison.angles() for comparison in comparisons])
    for axis, mark in enumerate("osD"):
        observed.plot(times, angles[:, axis], ls="", marker=mark, ms=5, label=f"{'xyz'[axis]}")
    observed.set(ylim=(0, None))
    observed.set_title("angle between the simulated body axes and those that radar saw, degrees")
    for found in methods.values():
        drift.semilogy(found.days * 86400, np.maximum(found.drift, FLOOR), label=found.method)
        # An error too small to tell, such as that at the start, has no place on the scale.
        error.semilogy(found.days * 86400, np.where(found.error > 0, found.error, np.nan), label=found.method)
    drift.set(ylim=(FLOOR / 4, None))
    drift.set_title("relative energy drift in steps of one hour")
    error.set(xlim=(0, run.time[-1]))
    error.set_title("error of the attitude in steps of one hour, degrees: a kept energy does not make it small")
    for panel in (observed, drift, error):
        panel.legend(loc="center left", bbox_to_anchor=(1, 0.5), fontsize="small")
    figure.savefig(file, pil_kwargs={"optimize": True})
    plt.close(figure)
