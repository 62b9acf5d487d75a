"""Figures of a trajectory. Each panel can be read in grey: curves differ in dashes, too."""
from __future__ import annotations

from typing import Any, Iterable, Mapping, Optional, Sequence

import numpy as np

from stiefel._results import body, diagram, sphere
from stiefel._results.base import Array
from stiefel._results.extras import imported

Trajectory = Any  # a `stiefel.Trajectory`

FLOOR = 2.0**-53  #: the rounding unit; smaller drifts are drawn as this value
MOST = 6  #: curves of a matrix
STYLE = {"axes.spines.top": False, "axes.spines.right": False, "axes.grid": True, "grid.color": "#e2e8f0",
         "axes.axisbelow": True, "axes.titlesize": "medium", "axes.titlelocation": "left", "legend.frameon": False,
         "legend.fontsize": "small", "lines.linewidth": 1.3}


def panels_of(trajectory: Trajectory) -> tuple[str, ...]:
    """Returns the panels that `plot` can draw of the trajectory's fields."""
    scene, there = scene_of(trajectory), trajectory.fields
    in_space = body.is_body(scene, trajectory)
    turns = in_space and body.attitudes(scene, trajectory, member_of(trajectory, 0)) is not None
    known = {"attitude": bool(there.keys() & {"quaternion", "Q", "q"}), "rates": bool(there), "spin_axis": turns,
             "polhode": in_space, "accuracy": True}
    return tuple(name for name, drawn in known.items() if drawn)


def plot(trajectory: Trajectory, panels: Optional[Sequence[str]], member: int, to: Optional[int], figure: Any) -> Any:
    """Does what `Trajectory.plot` says."""
    plt = imported("matplotlib.pyplot", "plot")

    scene, of, possible = scene_of(trajectory), member_of(trajectory, member), panels_of(trajectory)
    if panels is None:
        panels = [name for name in possible if name in ("attitude", "rates", "accuracy")]
    if not panels or not set(panels) <= set(possible):
        raise ValueError(f"panels: {list(panels)}: must be among {', '.join(possible)}, the panels of these fields")
    rows = [name for name in panels if name != "polhode"]
    made = figure is None
    with plt.rc_context(STYLE):
        square = "polhode" in panels
        if made:
            height = max(2.0 * len(rows) + 0.5, 4.2 if square else 0)
            width = (11.5 if rows else 5) if square else 8.5
            figure = plt.figure(figsize=(width, height), layout="constrained")
        ratios = [1.75, 1] if square and rows else [1]
        grid = figure.add_gridspec(max(len(rows), 1), len(ratios), width_ratios=ratios)
        first = None
        for k, name in enumerate(rows):
            alone = name == "accuracy" and to is not None  # it is about another span of time
            axes = figure.add_subplot(grid[k, 0], sharex=None if alone else first)
            if name == "accuracy":
                seconds = _accuracy(axes, trajectory, to)
            else:
                _curves(axes, trajectory.time, *_CURVES[name](scene, trajectory, of))
                first, seconds = first or axes, float(np.ptp(trajectory.time))
            axes.margins(x=0)
            axes.ticklabel_format(axis="x", style="plain", useOffset=False)
            if k == len(rows) - 1 or (rows[k + 1] == "accuracy" and to is not None):
                _label_time(axes, scene, seconds)
            else:
                axes.tick_params(labelbottom=False)
        if square:
            sphere.polhode(figure.add_subplot(grid[:, -1]), scene, trajectory, of)
    return _shown_once(figure) if made else figure


def _shown_once(figure: Any) -> Any:
    """A notebook shows the figures that pyplot holds at the end of a cell, and the cell's value besides."""
    plt = imported("matplotlib.pyplot", "plot")
    if "inline" in plt.get_backend():
        plt.close(figure)
    return figure


def scene_of(trajectory: Trajectory) -> Mapping[str, Any]:
    scene: Mapping[str, Any] = trajectory.scene
    return scene


def member_of(trajectory: Trajectory, member: int) -> Optional[int]:
    """Returns the member to draw; None for a single motion."""
    return member if scene_of(trajectory).get("members") else None


def unit(scene: Mapping[str, Any], name: str) -> str:
    """Returns the name of a unit for scenes with `body`, the only ones with units, else nothing."""
    return name if "body" in scene else ""


def _label_time(axes: Any, scene: Mapping[str, Any], seconds: float) -> None:
    """Names the axis of times and, where these are seconds, labels it in the unit that suits the span."""
    from matplotlib.ticker import FuncFormatter, MultipleLocator

    factor, name = next((found for found in ((86400, "days"), (3600, "hours")) if seconds >= 2 * found[0]), (1, "s"))
    if "body" in scene and factor > 1:
        most = seconds / factor / 5  # units between two ticks
        power = 10.0 ** np.floor(np.log10(most))
        axes.xaxis.set_major_locator(MultipleLocator(factor * power * max(one for one in (1, 2, 5) if one * power <= most)))
        axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value / factor:g}"))
    axes.set_xlabel("time" + unit(scene, f" ({name})"))


def _curves(axes: Any, time: Array, title: str, curves: Iterable[tuple[str, Array]]) -> None:
    for k, (name, values) in enumerate(curves):
        axes.plot(time, values, label=name, **diagram.line(k))
    axes.set_title(title)
    axes.legend(loc="center left", bbox_to_anchor=(1, 0.5))


Curves = tuple[str, list[tuple[str, Array]]]  # the title of a panel, and its curves by name


def _attitude(scene: Mapping[str, Any], trajectory: Trajectory, member: Optional[int]) -> Curves:
    if "quaternion" in trajectory.fields:
        values = body.vectors(trajectory.fields["quaternion"], member)
        return "attitude: quaternion, body to space", list(zip("wxyz", values.T))
    name = "Q" if "Q" in trajectory.fields else "q"
    return f"{name}: the entries that vary most", _entries(name, trajectory.fields[name], member)


def _rates(scene: Mapping[str, Any], trajectory: Trajectory, member: Optional[int]) -> Curves:
    if body.is_body(scene, trajectory):
        momenta = body.momenta(scene, trajectory, member)
        values = body.principal(scene, member).velocity(momenta)
        curves = [(rf"$\omega_{axis}$", values[:, k]) for k, axis in enumerate("xyz")]
        return "angular velocity in body axes" + unit(scene, ", rad/s"), curves
    rest = [name for name in trajectory.fields if name not in ("Q", "q", "Q_prev")] or list(trajectory.fields)
    name = next((name for name in ("Qdot", "qdot", "M") if name in rest), rest[0])
    return f"{name}: the entries that vary most", _entries(name, trajectory.fields[name], member)


def _spin_axis(scene: Mapping[str, Any], trajectory: Trajectory, member: Optional[int]) -> Curves:
    velocity = body.principal(scene, member).velocity(body.momenta(scene, trajectory, member))
    rotations = body.attitudes(scene, trajectory, member)
    assert rotations is not None  # or there is no such panel
    axis = np.einsum("sij,sj->si", rotations, velocity)
    axis /= np.maximum(np.linalg.norm(axis, axis=1, keepdims=True), np.finfo(float).tiny)
    return "spin axis in space, a unit vector", [(name, axis[:, k]) for k, name in enumerate("XYZ")]


_CURVES = {"attitude": _attitude, "rates": _rates, "spin_axis": _spin_axis}


def _entries(name: str, values: Array, member: Optional[int]) -> list[tuple[str, Array]]:
    """Returns the entries of a matrix that vary most, by name; of a skew one those above the diagonal."""
    values = body.matrices(values, member)
    rows, cols = values.shape[1:]
    vector = rows == 1
    found = []
    for i, j in np.ndindex(rows, cols):
        if name == "M" and rows == cols and i >= j:
            continue
        index = f"{j}" if vector else f"{i},{j}"
        parts = {"Re ": np.real(values), "Im ": np.imag(values)} if np.iscomplexobj(values) else {"": values}
        found += [(f"{part}{name}[{index}]", numbers[:, i, j]) for part, numbers in parts.items()]
    return sorted(found, key=lambda one: -np.ptp(one[1]))[:MOST]


def _accuracy(axes: Any, trajectory: Trajectory, to: Optional[int]) -> float:
    """Draws drift and error, and returns the time up to which they go."""
    from stiefel._report import run_data

    with trajectory.origin.session(trajectory.scene) as session:
        run = run_data.accuracy(session, max(0, int(trajectory.step.max())) if to is None else to)
    for k, family in enumerate(run.families):
        axes.semilogy(run.time, np.maximum(family.drift, FLOOR), label=f"drift of {family.name}", **diagram.line(k))
    for name, look in (("attitude", {"color": "black", "marker": "o"}), ("momentum", {"color": "0.45", "marker": "s"})):
        if run.error_time:
            axes.semilogy(run.error_time, np.maximum(run.errors[name], FLOOR), lw=1, ls="-", ms=3.5, clip_on=False, zorder=5,
                          label=f"error of the {name}", **look)
    axes.set_title("relative drift of the invariants, and estimated error" if run.error_time else
                   "relative drift of the invariants; the error is not estimated")
    axes.set_ylim(bottom=FLOOR / 2)
    axes.legend(loc="center left", bbox_to_anchor=(1, 0.5))
    return abs(run.horizon)


def polhode(trajectory: Trajectory, axes: Any, member: int) -> Any:
    """Does what `Trajectory.polhode` says."""
    plt = imported("matplotlib.pyplot", "plot")

    scene, of = scene_of(trajectory), member_of(trajectory, member)
    if not body.is_body(scene, trajectory):
        raise ValueError("the trajectory has no momentum or angular velocity of a body in three dimensions")
    made = axes is None
    if made:
        _, axes = plt.subplots(figsize=(5, 5.2), layout="constrained")
    sphere.polhode(axes, scene, trajectory, of)
    return _shown_once(axes.figure) if made else axes.figure


def plot3d(trajectory: Trajectory, axes: Any, coordinates: Sequence[int], member: int) -> Any:
    """Does what `Trajectory.plot3d` says."""
    plt = imported("matplotlib.pyplot", "plot")

    of, scene = member_of(trajectory, member), scene_of(trajectory)
    name = next((name for name in ("Q", "q") if name in trajectory.fields), None)
    frames = body.attitudes(scene, trajectory, of) if body.is_attitude(scene) else None
    turns = frames is not None
    if frames is None and name is None:
        raise ValueError("the trajectory has no frame; ask for the field Q or quaternion")
    if frames is None:
        frames = body.matrices(trajectory.fields[name], of)
    if np.iscomplexobj(frames):
        raise ValueError(f"{name} is complex: plot3d shows real frames")
    size = max(frames.shape[1:])
    three = tuple(coordinates)
    if len(three) != 3 or any(not 0 <= one < max(size, 3) for one in three):
        raise ValueError(f"coordinates: {coordinates!r}: must be three of 0 to {size - 1}")
    made = axes is None
    if made:
        figure = plt.figure(figsize=(6.6, 5.4))
        axes = figure.add_axes((0.02, 0.04, 0.74, 0.92), projection="3d")
    sphere.frames(axes, frames, three, body=turns)
    return _shown_once(axes.figure) if made else axes.figure
