"""Styles of curves that can be told apart without colours.

The colours are those of Okabe and Ito, which can be told apart in every kind of colour vision, without yellow, which is
too pale for a line on white, and without black, which is kept for the foreground. Dashes and marks differ, too, for
greyscale and print.
"""
from __future__ import annotations

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


def pareto_front(points: Iterable[tuple[float, float]]) -> list[tuple[float, float]]:
    """Returns the points that no other one beats in both cost and error, the cheapest first."""
    by_cost = sorted(points)
    return [one for k, one in enumerate(by_cost) if all(one[1] < other[1] for other in by_cost[:k])]
