"""Pictures on a sphere, in orthographic projection: what is behind it is pale."""
from __future__ import annotations

from typing import Any, Iterator, Mapping, Optional

import numpy as np

from stiefel._results import body, diagram
from stiefel._results.base import Array

Trajectory = Any  # a `stiefel.Trajectory`
TURN = np.linspace(0, 2 * np.pi, 181)


def polhode(axes: Any, scene: Mapping[str, Any], trajectory: Trajectory, member: Optional[int]) -> None:
    """Draws the momentum in the body, divided by its norm, on the sphere of principal axes, with the separatrix and the
    polhodes of other energies. The axis that the momentum circles is turned towards the viewer."""
    inertia = body.principal(scene, member)
    momenta = body.momenta(scene, trajectory, member) @ inertia.axes.T
    norms = np.linalg.norm(momenta, axis=1, keepdims=True)
    if not norms[0] > 0:
        raise ValueError("the body is at rest, so that there is no polhode")
    path = momenta / norms
    level = np.sum(path[0] ** 2 / inertia.moments) * inertia.moments[1]
    view = _view(0.6, 0.9 * np.copysign(1, path[0, 2])) if level < 1 else _view(0.5 + np.pi * (path[0, 0] < 0), 0.35)
    axes.set(xlim=(-1.25, 1.25), ylim=(-1.25, 1.25), aspect="equal")
    axes.axis("off")
    axes.fill(np.cos(TURN), np.sin(TURN), fc="#f3f6f9", ec="0.6", lw=0.8, zorder=0)
    if inertia.distinct:
        for curve in other_polhodes(inertia.moments):
            _draw(axes, view, curve, color="0.68", lw=0.6)
        for k, curve in enumerate(separatrix(inertia.moments)):
            _draw(axes, view, curve, color="black", lw=1, ls=(0, (5, 3)), label="separatrix" if k == 0 else None)
    _draw(axes, view, path, color=diagram.COLOURS[0], lw=1.8, label="polhode")
    start = view @ path[0]
    axes.plot(*start[:2], "o", ms=6, color=diagram.COLOURS[1], mec="white", zorder=5, alpha=1 if start[2] >= 0 else 0.4, label="start")
    for sign in (1, -1):
        for axis, name in zip(np.eye(3), inertia.names):
            x, y, depth = view @ axis * sign
            alpha = 1 if depth >= 0 else 0.35
            axes.plot(x, y, "k.", ms=5, alpha=alpha, zorder=7)
            away = 1 + 0.14 / max(np.hypot(x, y), 0.01)
            axes.annotate(("+" if sign > 0 else "\N{MINUS SIGN}") + name, (away * x, away * y), alpha=alpha, ha="center",
                          va="center", zorder=6, bbox={"fc": "white", "ec": "none", "alpha": 0.6, "pad": 0.5})
    axes.set_title("polhode on the momentum sphere")
    told = [f"moments {' : '.join(inertia.names)} = {' : '.join(f'{moment:.5g}' for moment in inertia.moments / inertia.moments[0])}"]
    if inertia.names == ("a", "b", "c"):
        told += [f"{name} = ({', '.join(f'{one:.3g}' for one in axis + 0)}) in body axes x, y, z"
                 for name, axis in zip(inertia.names, inertia.axes.round(9))]
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, 0.02), ncol=3, frameon=False, title="\n".join(told),
                fontsize="small", title_fontsize="small")


def _view(azimuth: float, elevation: float) -> Array:
    """Returns the rotation to the axes of the picture: right, up, towards the viewer."""
    c, s, C, S = np.cos(azimuth), np.sin(azimuth), np.cos(elevation), np.sin(elevation)
    return np.array([[-s, c, 0], [-S * c, -S * s, C], [C * c, C * s, S]])


def _draw(axes: Any, view: Array, points: Array, label: Optional[str] = None, **look: Any) -> None:
    x, y, depth = view @ points.T
    for front in (True, False):
        here = (depth >= 0) == front
        shown = here | np.append(here[1:], False)  # a segment that crosses the edge belongs to both sides
        axes.plot(np.where(shown, x, np.nan), np.where(shown, y, np.nan), alpha=1 if front else 0.25,
                  zorder=3 if front else 1, label=label if front else None, **look)


def other_polhodes(moments: Array) -> Iterator[Array]:
    """Yields the curves of some energies between those of the axes and that of the separatrix."""
    inverse = 1 / moments
    for k in (0, 2):
        i, j = (k + 1) % 3, (k + 2) % 3
        for part in (0.25, 0.5, 0.75):
            level = part * (inverse[1] - inverse[k])
            for sign in (1, -1):
                curve = np.empty((len(TURN), 3))
                curve[:, i] = np.sqrt(level / (inverse[i] - inverse[k])) * np.cos(TURN)
                curve[:, j] = np.sqrt(level / (inverse[j] - inverse[k])) * np.sin(TURN)
                curve[:, k] = sign * np.sqrt(np.maximum(0, 1 - curve[:, i] ** 2 - curve[:, j] ** 2))
                yield curve


def separatrix(moments: Array) -> Iterator[Array]:
    """Yields the two great circles on which 2E / |m|^2 is that of the middle axis."""
    a, b, c = 1 / moments
    slope = np.sqrt((a - b) / (b - c))
    for sign in (1, -1):
        side = np.array([1, 0, sign * slope]) / np.hypot(1, slope)
        yield np.outer(np.cos(TURN), side) + np.outer(np.sin(TURN), [0, 1, 0])


def frames(axes: Any, values: Array, coordinates: tuple[int, int, int], body: bool = False) -> None:
    """Draws the paths of the vectors of frames, (samples, rows, cols), on three coordinates, and the vectors at the end.

    The vectors are the rows for rows < cols, else the columns, at most six. `body`: whether the frames are attitudes of a body,
    whose columns are its axes in space.
    """
    by_rows = values.shape[1] < values.shape[2]
    moved = values if by_rows else values.transpose(0, 2, 1)
    known = moved.shape[2]
    shown = np.stack([moved[:, :, k] if k < known else np.zeros(moved.shape[:2]) for k in coordinates], axis=-1)
    for k in range(min(moved.shape[1], 6)):
        look, mark = diagram.line(k), diagram.MARKS[k]
        name = f"body {'xyz'[k]}" if body else "q" if values.shape[1] == 1 else f"{'row' if by_rows else 'column'} {k}"
        axes.plot(*shown[:, k].T, lw=1, alpha=0.75, **look)
        axes.plot(*zip((0, 0, 0), shown[-1, k]), lw=2.2, color=look["color"], marker=mark, markevery=[1], ms=6)
        axes.plot([], [], [], marker=mark, ms=5, label=name, **look)
    for pane in (axes.xaxis, axes.yaxis, axes.zaxis):
        pane.set_pane_color((1, 1, 1, 0))
    axes.set(xlim=(-1, 1), ylim=(-1, 1), zlim=(-1, 1), xticks=(-1, 0, 1), yticks=(-1, 0, 1), zticks=(-1, 0, 1),
             **{f"{axis}label": f"space {'XYZ'[k]}" if body else f"coordinate {k}" for axis, k in zip("xyz", coordinates)})
    axes.set_box_aspect((1, 1, 1))
    axes.legend(loc="upper left", bbox_to_anchor=(1.03, 0.9), frameon=False)
