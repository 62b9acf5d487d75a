"""Styles of curves that can be told apart without colours, and labels at the ends of curves.

The colours are those of Okabe and Ito, which can be told apart in every kind of colour vision, without yellow, which is
too pale for a line on white, and without black, which is kept for the foreground. Dashes and marks differ, too, for
greyscale and print.
"""
from __future__ import annotations

import math
from typing import Any, Iterable, NamedTuple, Sequence

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
DASHES = ("-", (0, (5, 1.5)), (0, (6, 1.5, 1, 1.5)), (0, (1.2, 1.2)), (0, (9, 2, 1, 2, 1, 2)))
MARKS = "osD^vPX<>*p"
GREY = "0.82"  #: the colour of curves in the background


def style(k: int) -> dict[str, Any]:
    """Returns colour, dashes and mark of curve k. No two of the first 330 curves share all three."""
    return {"color": COLOURS[k % len(COLOURS)], "linestyle": DASHES[k % len(DASHES)], "marker": MARKS[k % len(MARKS)]}


def deep(colour: Any) -> tuple[float, ...]:
    """Returns the colour darkened, so that small letters in it are legible."""
    from matplotlib.colors import to_rgb

    return tuple(0.65 * part for part in to_rgb(colour))


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


class End(NamedTuple):
    """The end of a curve in the units of the axes, and the curve's name."""

    x: float
    y: float
    text: str
    colour: Any


def label_ends(axes: Any, ends: Sequence[End], curves: Iterable[Sequence[tuple[float, float]]] = (),
               size: float = 7.5) -> None:
    """Writes each name beside the end of its curve. A name that would cover another name, one of `curves` or the edge
    of the axes is shifted and joined to the end by a thin line. The axes keep their limits."""
    import numpy as np
    from matplotlib.patheffects import withStroke

    axes.set(xlim=axes.get_xlim(), ylim=axes.get_ylim())
    axes.figure.canvas.draw()
    renderer, frame = axes.figure.canvas.get_renderer(), axes.get_window_extent()
    inked = np.concatenate([np.empty((0, 2)), *(_pixels(axes.transData.transform(curve)) for curve in curves)])
    taken: list[Any] = []

    def cost(box: Any, side: int, dy: int) -> float:
        outside = box.x0 < frame.x0 or box.x1 > frame.x1 or box.y0 < frame.y0 or box.y1 > frame.y1
        covered = np.count_nonzero((abs(inked - [(box.x0 + box.x1) / 2, (box.y0 + box.y1) / 2])
                                    < [box.width / 2, box.height / 2]).all(axis=1))
        return float(1e6 * outside + 1e4 * sum(box.overlaps(other) for other in taken) + 2 * covered
                     + abs(dy) + (25 if side < 0 else 0))

    for end in sorted(ends, key=lambda e: (-e.y, e.x)):
        label = axes.annotate(
            end.text, (end.x, end.y), xytext=(7, 0), textcoords="offset points", fontsize=size, color=deep(end.colour),
            va="center", zorder=10, path_effects=[withStroke(linewidth=2.5, foreground="white")],
            arrowprops={"arrowstyle": "-", "color": end.colour, "lw": 0.6, "shrinkA": 0, "shrinkB": 3})
        label.set_in_layout(False)

        def place(side: int, dy: int) -> Any:
            label.set_position((side * (7 if dy == 0 else 14), dy))
            label.set_ha("left" if side > 0 else "right")
            return _text_box(label, renderer)

        best = min(((cost(place(side, dy), side, dy), side, dy) for dy in range(-90, 91, 3) for side in (1, -1)),
                   key=lambda found: found[0])
        taken.append(place(*best[1:]))


def save(figure: Any, file: Any, dpi: float = 100) -> None:
    """Saves the figure as an optimized PNG in full colour."""
    from io import BytesIO

    from PIL import Image

    drawn = BytesIO()
    figure.savefig(drawn, format="png", dpi=dpi)
    with Image.open(drawn) as image:
        image.convert("RGB").save(file, format="png", optimize=True)


def _pixels(corners: Any) -> Any:
    """Returns points four pixels apart on the line through `corners`."""
    import numpy as np

    if len(corners) < 2:
        return corners
    way = np.concatenate([[0], np.cumsum(np.hypot(*np.diff(corners, axis=0).T))])
    at = np.linspace(0, way[-1], 2 + int(way[-1] / 4))
    return np.column_stack([np.interp(at, way, corners[:, k]) for k in (0, 1)])


def _text_box(label: Any, renderer: Any) -> Any:
    """Returns the box of a label's text, without the line that leads to it."""
    from matplotlib.text import Text

    label.update_positions(renderer)
    return Text.get_window_extent(label, renderer)
