"""The methods by which samples are drawn."""
from __future__ import annotations

import os
from typing import Any, Mapping, Optional, Sequence

from stiefel._results import plots


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
    def panels(self) -> tuple[str, ...]:
        """The panels that `plot` can draw of these fields."""
        return plots.panels_of(self)

    def plot(self, panels: Optional[Sequence[str]] = None, *, member: int = 0, to: Optional[int] = None,
             figure: Any = None) -> Any:
        """Returns a figure of matplotlib with panels, by default attitude, rates and accuracy:

        "attitude": the quaternion, or the entries of the frame that vary most; "rates": the angular velocity in body axes,
        or the entries of the other field that vary most; "spin_axis": the direction of the angular velocity in space;
        "accuracy": the drift of each family of invariants beside the estimated error; "polhode": see `polhode`.

        Drift and error are computed again from the scene, at the server of the run or at that of `stiefel.simulate` if the
        client of the run is closed, up to the last sample or up to step `to`. `member`: the member of an ensemble to draw.
        `figure`: the figure or subfigure to draw in; a new one by default. Needs matplotlib: stiefel[plot].
        """
        return plots.plot(self, panels, member, to, figure)

    def polhode(self, axes: Any = None, *, member: int = 0) -> Any:
        """Returns a figure of matplotlib with the polhode of a body in three dimensions: its momentum in the body, divided
        by its norm, on the sphere, with the separatrix, the principal axes and the polhodes of other energies.

        `axes`: the matplotlib axes to draw in; new ones by default. `member`: the member of an ensemble to draw. Needs
        matplotlib: stiefel[plot].
        """
        return plots.polhode(self, axes, member)

    def plot3d(self, axes: Any = None, *, coordinates: Sequence[int] = (0, 1, 2), member: int = 0) -> Any:
        """Returns a figure of matplotlib with the paths of the vectors of the frame, projected on three coordinates, and
        the vectors at the last sample. The vectors are the rows of Q for n < N, else its columns, at most six: of a body its
        axes x, y, z in space.

        `axes`: the 3-D axes of matplotlib to draw in; new ones by default. `member`: the member of an ensemble to draw.
        Needs matplotlib: stiefel[plot].
        """
        return plots.plot3d(self, axes, coordinates, member)

    def report(self, path: "str | os.PathLike[str]", *, name: Optional[str] = None, member: int = 0,
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

        page.report(self, path, name, member, estimate_error, tradeoff)
