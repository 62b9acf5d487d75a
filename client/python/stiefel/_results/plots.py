"""Pictures of samples: figures, the viewer of Rerun and the page. Each panel can be read in grey: curves differ in dashes, too."""
from __future__ import annotations

import os
from typing import Any, Mapping, Optional, Sequence

import numpy as np

from stiefel._results import body, diagram, sphere
from stiefel._results.base import Array
from stiefel._results.extras import imported

Trajectory = Any  # a `stiefel.Trajectory`
Scene = Mapping[str, Any]

FLOOR = 2.0**-53  #: the rounding unit; smaller drifts are drawn as this value
MOST = 6  #: curves of a matrix
STYLE = {"axes.spines.top": False, "axes.spines.right": False, "axes.grid": True, "grid.color": "#e2e8f0",
         "axes.axisbelow": True, "axes.titlesize": "medium", "axes.titlelocation": "left", "legend.frameon": False,
         "legend.fontsize": "small", "lines.linewidth": 1.3}


class Logged:
    """Samples that go to a viewer."""

    def log_to_rerun(self, scene: Optional[Mapping[str, Any]] = None, *, entity: str = "stiefel",
                     recording: Any = None) -> None:
        """Logs the samples to the viewer of Rerun, on the timelines `step` and `time`, batch by batch of a stream:

            rerun.init("tumbling", spawn=True)
            for batch in session.stream(to=10_000):
                batch.log_to_rerun(session.scene)

        A body in three dimensions is a box that turns, with its axes, its spin axis and its momentum; a frame is arrows, its
        first three coordinates; every field is curves, at most 16. The bodies of an ensemble stand on a grid, each below
        its own entity. `scene`: the session's scene; a trajectory knows it. `recording`: a recording of Rerun; by default
        the one of `rerun.init`. Needs rerun-sdk: stiefel[rerun].
        """
        from stiefel._report import rerun

        scene = getattr(self, "scene", None) if scene is None else scene
        if scene is None:
            raise ValueError("scene: must be given for a batch, which does not know it: session.scene")
        rerun.log(self, scene, entity, recording)


class Drawn(Logged):
    """A trajectory, which knows its scene."""

    @property
    def panels(self: Trajectory) -> tuple[str, ...]:
        """The panels that `plot` can draw of these fields."""
        there = self.fields
        in_space = body.is_body(self)
        turns = in_space and body.attitudes(self, member_of(self, 0)) is not None
        known = {"attitude": bool(there.keys() & {"quaternion", "Q", "q"}), "rates": bool(there), "spin_axis": turns,
                 "polhode": in_space, "accuracy": True}
        return tuple(name for name, drawn in known.items() if drawn)

    def plot(self: Trajectory, panels: Optional[Sequence[str]] = None, *, member: int = 0, to: Optional[int] = None,
             figure: Any = None) -> Any:
        """Returns a figure of matplotlib with panels, by default attitude, rates and accuracy:

        "attitude": the quaternion, or the entries of the frame that vary most; "rates": the angular velocity in body axes,
        or the entries of the other field that vary most; "spin_axis": the direction of the angular velocity in space;
        "accuracy": the drift of each family of invariants beside the estimated error; "polhode": see `polhode`.

        Drift and error are computed again from the scene, at the server of the run or at that of `stiefel.simulate` if the
        client of the run is closed, up to the last sample or up to step `to`. `member`: the member of an ensemble to draw.
        `figure`: the figure or subfigure to draw in; a new one by default. Needs matplotlib: stiefel[plot].
        """
        plt = imported("matplotlib.pyplot", "plot")

        scene, of, possible = self.scene, member_of(self, member), self.panels
        if panels is None:
            panels = [name for name in possible if name in ("attitude", "rates", "accuracy")]
        if not panels or not set(panels) <= set(possible):
            raise ValueError(f"panels: {list(panels)}: must be among {', '.join(possible)}, the panels of these fields")
        rows, square, made = [name for name in panels if name != "polhode"], "polhode" in panels, figure is None
        with plt.rc_context(STYLE):
            if made:
                width = (11.5 if rows else 5) if square else 8.5
                figure = plt.figure(figsize=(width, max(2.0 * len(rows) + 0.5, 4.2 * square)), layout="constrained")
            ratios = [1.75, 1] if square and rows else [1]
            grid = figure.add_gridspec(max(len(rows), 1), len(ratios), width_ratios=ratios)
            first = None
            for k, name in enumerate(rows):
                alone = name == "accuracy" and to is not None  # it is about another span of time
                axes = figure.add_subplot(grid[k, 0], sharex=None if alone else first)
                if name == "accuracy":
                    seconds = _accuracy(axes, self, to)
                else:
                    title, curves = _CURVES[name](scene, self, of)
                    for j, (label, values) in enumerate(curves.items()):
                        axes.plot(self.time, values, label=label, **diagram.line(j))
                    axes.set_title(title)
                    first, seconds = first or axes, float(np.ptp(self.time))
                axes.legend(loc="center left", bbox_to_anchor=(1, 0.5))
                axes.margins(x=0)
                axes.ticklabel_format(axis="x", style="plain", useOffset=False)
                if k == len(rows) - 1 or (rows[k + 1] == "accuracy" and to is not None):
                    _label_time(axes, scene, seconds)
                else:
                    axes.tick_params(labelbottom=False)
            if square:
                sphere.polhode(figure.add_subplot(grid[:, -1]), scene, self, of)
        return _shown_once(figure) if made else figure

    def polhode(self: Trajectory, axes: Any = None, *, member: int = 0) -> Any:
        """Returns a figure of matplotlib with the polhode of a body in three dimensions: its momentum in the body, divided
        by its norm, on the sphere, with the separatrix, the principal axes and the polhodes of other energies.

        `axes`: the matplotlib axes to draw in; new ones by default. `member`: the member of an ensemble to draw. Needs
        matplotlib: stiefel[plot].
        """
        if not body.is_body(self):
            raise ValueError("the trajectory has no momentum or angular velocity of a body in three dimensions")
        made = axes is None
        if made:
            _, axes = imported("matplotlib.pyplot", "plot").subplots(figsize=(5, 5.2), layout="constrained")
        sphere.polhode(axes, self.scene, self, member_of(self, member))
        return _shown_once(axes.figure) if made else axes.figure

    def plot3d(self: Trajectory, axes: Any = None, *, coordinates: Sequence[int] = (0, 1, 2), member: int = 0) -> Any:
        """Returns a figure of matplotlib with the paths of the vectors of the frame, projected on three coordinates, and
        the vectors at the last sample. The vectors are the rows of Q for n < N, else its columns, at most six: of a body its
        axes x, y, z in space.

        `axes`: the 3-D axes of matplotlib to draw in; new ones by default. `member`: the member of an ensemble to draw.
        Needs matplotlib: stiefel[plot].
        """
        of = member_of(self, member)
        name = next((name for name in ("Q", "q") if name in self.fields), None)
        frames = body.attitudes(self, of)
        turns = frames is not None
        if frames is None:
            if name is None:
                raise ValueError("the trajectory has no frame; ask for the field Q or quaternion")
            frames = body.matrices(self.fields[name], of)
        if np.iscomplexobj(frames):
            raise ValueError(f"{name} is complex: plot3d shows real frames")
        size, three = max(frames.shape[1:]), tuple(coordinates)
        if len(three) != 3 or any(not 0 <= one < max(size, 3) for one in three):
            raise ValueError(f"coordinates: {coordinates!r}: must be three of 0 to {size - 1}")
        made = axes is None
        if made:
            figure = imported("matplotlib.pyplot", "plot").figure(figsize=(6.6, 5.4))
            axes = figure.add_axes((0.02, 0.04, 0.74, 0.92), projection="3d")
        sphere.frames(axes, frames, three, body=turns)
        return _shown_once(axes.figure) if made else axes.figure

    def report(self: Trajectory, path: "str | os.PathLike[str]", *, name: Optional[str] = None, member: int = 0,
               estimate_error: bool = True, tradeoff: Optional[bool] = None) -> None:
        """Writes an HTML page about the run from step 0 to the last sample, which needs no network.

        It has the body turning in space, polhode, rates, drift beside the estimated error, error against cost of the
        methods, the scene, and how to run it again: the page of `stiefel report`. The run is computed again from the
        scene, at the server of the run or at that of `stiefel.simulate` if the client of the run is closed, with samples
        dense enough to be drawn.

        `name`: the title, by default the system. `member`: the member of an ensemble to draw. `estimate_error`: whether
        the error is estimated, which takes at most about ten seconds. `tradeoff`: whether error against cost is measured,
        for about ten seconds; by default for about a second, and not for ensembles.
        """
        from stiefel._report import page

        with self.origin.session(self.scene) as session:
            page.write(path, session, max(0, int(self.step.max())), name, member, estimate_error, tradeoff)


def _shown_once(figure: Any) -> Any:
    """A notebook shows the figures that pyplot holds at the end of a cell, and the cell's value besides."""
    plt = imported("matplotlib.pyplot", "plot")
    if "inline" in plt.get_backend():
        plt.close(figure)
    return figure


def member_of(trajectory: Trajectory, member: int) -> Optional[int]:
    """Returns the member to draw; None for a single motion."""
    return member if trajectory.scene.get("members") else None


def _label_time(axes: Any, scene: Scene, seconds: float) -> None:
    """Names the axis of times and, where these are seconds, labels it in the unit that suits the span."""
    from matplotlib.ticker import FuncFormatter, MultipleLocator

    if "body" not in scene:
        axes.set_xlabel("time")
        return
    factor, name = next((found for found in ((86400, "days"), (3600, "hours")) if seconds >= 2 * found[0]), (1, "s"))
    if factor > 1:
        most = seconds / factor / 5  # units between two ticks
        power = 10.0 ** np.floor(np.log10(most))
        axes.xaxis.set_major_locator(MultipleLocator(factor * power * max(one for one in (1, 2, 5) if one * power <= most)))
        axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value / factor:g}"))
    axes.set_xlabel(f"time ({name})")


Curves = tuple[str, dict[str, Array]]  # the title of a panel, and its curves by name


def _attitude(scene: Scene, trajectory: Trajectory, member: Optional[int]) -> Curves:
    if "quaternion" in trajectory.fields:
        return "attitude: quaternion, body to space", dict(zip("wxyz", body.vectors(trajectory.fields["quaternion"], member).T))
    return _entries("Q" if "Q" in trajectory.fields else "q", trajectory, member)


def rates(scene: Scene, trajectory: Trajectory, member: Optional[int]) -> Curves:
    if body.is_body(trajectory):
        values = body.velocities(scene, trajectory, member)
        title = "angular velocity in body axes" + ", rad/s" * ("body" in scene)
        return title, {rf"$\omega_{axis}$": values[:, k] for k, axis in enumerate("xyz")}
    rest = [name for name in trajectory.fields if name not in ("Q", "q", "Q_prev")] or list(trajectory.fields)
    return _entries(next((name for name in ("Qdot", "qdot", "M") if name in rest), rest[0]), trajectory, member)


def _spin_axis(scene: Scene, trajectory: Trajectory, member: Optional[int]) -> Curves:
    rotations = body.attitudes(trajectory, member)
    assert rotations is not None  # or there is no such panel
    axis = np.einsum("sij,sj->si", rotations, body.velocities(scene, trajectory, member))
    axis /= np.maximum(np.linalg.norm(axis, axis=1, keepdims=True), np.finfo(float).tiny)
    return "spin axis in space, a unit vector", dict(zip("XYZ", axis.T))


_CURVES = {"attitude": _attitude, "rates": rates, "spin_axis": _spin_axis}


def _entries(name: str, trajectory: Trajectory, member: Optional[int]) -> Curves:
    """Returns the entries of a field that vary most; of a skew matrix those above the diagonal."""
    values = body.matrices(trajectory.fields[name], member)
    rows, cols = values.shape[1:]
    parts = {"Re ": np.real(values), "Im ": np.imag(values)} if np.iscomplexobj(values) else {"": values}
    vary = np.stack([np.ptp(numbers, axis=0) for numbers in parts.values()])
    if name == "M" and rows == cols:
        vary[:, np.tri(rows, dtype=bool)] = -1
    found = {}
    for k, i, j in zip(*np.unravel_index(np.argsort(-vary, axis=None, kind="stable")[:MOST], vary.shape)):
        if vary[k, i, j] >= 0:
            found[f"{[*parts][k]}{name}[{j if rows == 1 else f'{i},{j}'}]"] = [*parts.values()][k][:, i, j]
    return f"{name}: the entries that vary most", found


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
    return abs(run.horizon)
