"""Makes the table and the picture of the long runs: curves of an error over the number of steps."""
from __future__ import annotations

import math
import re
from collections import defaultdict

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

from records import number

CURVE = re.compile(r"(energy|momentum|orthogonality|phase) at (\d+)$")
PANELS = ["energy", "momentum", "orthogonality", "phase"]
# The colours of Okabe and Ito can be told apart with every kind of colour blindness, the markers in greyscale.
STYLES = [("#000000", "o"), ("#0072B2", "s"), ("#D55E00", "^"), ("#56B4E9", "D"), ("#CC79A7", "v"), ("#009E73", "P")]


def long_runs(records):
    """Returns the lines of the table, with the last value and the growth exponent of every curve, and the curves."""
    curves = defaultdict(dict)
    exponents = {}
    for r in records:
        key = r["row"], r["arithmetic"]
        if found := CURVE.match(r["measure"]):
            curves[(*key, found[1])][int(found[2])] = r
        elif r["measure"].startswith("exponent of "):
            exponents[(*key, r["measure"].removeprefix("exponent of "))] = r
    lines = ["| row | arithmetic | of | steps | at the end | bound | exponent, last three decades | bound | s |",
             "| --- " * 9 + "|"]
    for (row, arithmetic, of), points in curves.items():
        last = max(points)
        exponent = exponents.pop((row, arithmetic, of), None)
        tail = f"{exponent['value']:.2f} | {exponent['bound']}" if exponent else f"{fit(points):.2f} | "
        lines.append(f"| {row} | {arithmetic} | {of} | {last:.0e} | {number(points[last]['value'])} | "
                     f"{number(points[last]['bound'])} | {tail} | {points[last]['seconds']:.0f} |")
    for (row, arithmetic, of), r in exponents.items():
        lines.append(f"| {row} | {arithmetic} | {of} | | | | {r['value']:.2f} | {r['bound']} | {r['seconds']:.0f} |")
    return lines, curves


def fit(points):
    """Returns the slope of log error over log steps in the last three decades."""
    last = math.log10(max(points))
    xy = [(math.log10(k), math.log10(r["value"])) for k, r in points.items()
          if r["value"] > 0 and math.log10(k) >= last - 3.01]
    if len(xy) < 2:
        return math.nan
    x, y = (sum(v) / len(xy) for v in zip(*xy))
    return sum((a - x) * (b - y) for a, b in xy) / sum((a - x) ** 2 for a, _ in xy)


def draw_panel(axis, panel, curves, styles):
    for (row, arithmetic, of), points in curves.items():
        if of != panel:
            continue
        steps = sorted(points)
        colour, marker = styles[row]
        dash = "-" if arithmetic == "compensated" else "--"
        axis.loglog(steps, [points[k]["value"] for k in steps], dash, marker=marker, markersize=3.5, color=colour,
                    label=f"{row}, {arithmetic}", linewidth=1.4)
    power = 1.5 if panel == "phase" else 0.5
    ends = [1e1, 1e6 if panel == "phase" else 1e8]
    base = axis.get_ylim()[0]
    axis.loglog(ends, [base * (k / ends[0]) ** power for k in ends], ":", color="0.6", linewidth=1)
    axis.annotate(f"steps$^{{{power}}}$", (ends[-1], base * (ends[-1] / ends[0]) ** power), color="0.4", ha="right",
                  va="bottom", fontsize=9)
    axis.set_title(panel if panel != "phase" else "phase, against the same map in quadruple precision", fontsize=10)
    axis.grid(True, which="major", color="0.92")
    for side in ("top", "right"):
        axis.spines[side].set_visible(False)


def draw(curves, path):
    figure, axes = plt.subplots(2, 2, figsize=(11, 8), sharex=True, constrained_layout=True)
    styles = dict(zip(dict.fromkeys(row for row, _, _ in curves), STYLES))
    for panel, axis in zip(PANELS, axes.flat):
        draw_panel(axis, panel, curves, styles)
    for axis in axes[1]:
        axis.set_xlabel("steps")
        axis.tick_params(labelbottom=True)
    for axis in axes[:, 0]:
        axis.set_ylabel("error, root mean square")
    legend = {}
    for axis in axes.flat:
        for handle, label in zip(*axis.get_legend_handles_labels()):
            legend.setdefault(label, handle)
    figure.legend(legend.values(), legend.keys(), loc="upper center", bbox_to_anchor=(0.5, 0), ncol=3, frameon=False,
                  fontsize=9)
    figure.savefig(path, dpi=110, bbox_inches="tight")
