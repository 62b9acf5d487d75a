"""Styles of curves that can be told apart without colours, and which of several curves is the best.

The colours are those of Okabe and Ito, which can be told apart in every kind of colour vision, without yellow, which is
too pale for a line on white, and without black, which is kept for the foreground. Dashes and marks differ, too, for
greyscale and print.
"""
from __future__ import annotations

import math
from typing import Any, Iterable

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
DASHES = ("-", (0, (5, 1.5)), (0, (6, 1.5, 1, 1.5)), (0, (1.2, 1.2)), (0, (9, 2, 1, 2, 1, 2)))
MARKS = "osD^vPX<>*p"
GREY = "0.82"  #: the colour of curves in the background


def style(k: int) -> dict[str, Any]:
    """Returns colour, dashes and mark of curve k. No two of the first 330 curves share all three."""
    return {"color": COLOURS[k % len(COLOURS)], "linestyle": DASHES[k % len(DASHES)], "marker": MARKS[k % len(MARKS)]}


def line(k: int) -> dict[str, Any]:
    """Returns colour and dashes of curve k without marks, for curves of many samples."""
    return {"color": COLOURS[k % len(COLOURS)], "linestyle": DASHES[k % len(DASHES)]}


def dominated_area(points: Iterable[tuple[float, float]], corner: tuple[float, float]) -> float:
    """Returns the area of the log-log picture below and left of `corner` in which some point is better in both cost and
    error. The larger the area, the better the curve."""
    area, level = 0.0, corner[1]
    for cost, error in sorted(points):
        if 0 < cost < corner[0] and 0 < error < level:
            area += math.log(corner[0] / cost) * math.log(level / error)
            level = error
    return area


def pareto_front(points: Iterable[tuple[float, float]]) -> list[tuple[float, float]]:
    """Returns the points that no other one beats in both cost and error, the cheapest first."""
    front: list[tuple[float, float]] = []
    for cost, error in sorted(points):
        if not front or error < front[-1][1]:
            front.append((cost, error))
    return front
