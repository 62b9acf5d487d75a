"""What frames and motions are turned into: the same motion in other variables, and the geodesics between frames."""
from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Callable, Optional, Sequence, overload

from stiefel._results.base import Array, ByValue, Ended, RunStatus
from stiefel._results.server_catalogue import Choice

__all__ = ["ConjugatePoint", "ConjugatePoints", "Conversion", "Geodesic"]


@dataclass(frozen=True, eq=False, repr=False)
class Conversion(ByValue):
    """A motion in the variables of another system, as a scene or as blocks."""

    scene: Optional[dict[str, Any]]  #: the resolved scene; None if the target is not a system
    blocks: dict[str, Array]  #: the blocks by name if the target is not a system, else empty
    margins: dict[str, float]  #: distance from the edge of each domain, by the domain's name: positive inside

    choice: Optional[Choice] = None  #: the method that was chosen if the scene had a tolerance


@dataclass(frozen=True, eq=False, repr=False)
class Geodesic(Ended, ByValue):
    """The geodesic that joins two frames. If `outcome` is not REACHED, none was found."""

    _scene: Optional[Callable[[], dict[str, Any]]] = field(repr=False, compare=False)
    velocity: Optional[Array]  #: Qdot at Q_0; None for the discrete problem
    energy: float
    residual: float  #: max |Q(time) - Q_T|
    #: whether it is the shortest geodesic between the frames: "yes" is proved; "none_shorter_found": a search was
    #: completed; "no": a shorter path was seen; "ended": the budget ended the search, and this is the shortest so far;
    #: "unknown": a search was not completed, or the discrete problem
    shortest: str
    distinct: int  #: how many different geodesics the search has seen
    trajectory: Optional[Array]  #: the frames, (samples + 1, n, N); None without samples
    run_status: RunStatus

    @cached_property
    def scene(self) -> Optional[dict[str, Any]]:
        """The scene of the motion from Q_0 at time 0 to Q_T at the given time, made when somebody asks for it; None where the
        call did not ask for it, and in a metric that no Lambda has."""
        return self._scene and self._scene()


@dataclass(frozen=True, eq=False, repr=False)
class ConjugatePoint(ByValue):
    """A time at which the differential of the exponential map, from velocities at time 0 to frames, is singular."""

    time: float
    multiplicity: int
    kernel: Array  #: (multiplicity, n, N): changes of Qdot(0) that do not change Q(time), orthonormal in the metric
    gap: Optional[float]  #: sin(theta) of the next field, tan(theta) = |J| / (t |DJ/dt|); None if there is none


@dataclass(frozen=True, eq=False, repr=False)
class ConjugatePoints(Ended, ByValue, Sequence[ConjugatePoint]):
    """The conjugate points along a geodesic, in the order of their times."""

    points: tuple[ConjugatePoint, ...]
    until: float  #: every conjugate point up to this time is here: `time`, or less if `outcome` is not REACHED
    run_status: RunStatus
    work: float = field(default=0.0, compare=False)  #: measured instructions

    @overload
    def __getitem__(self, index: int) -> ConjugatePoint: ...
    @overload
    def __getitem__(self, index: slice) -> tuple[ConjugatePoint, ...]: ...
    def __getitem__(self, index: Any) -> Any:
        return self.points[index]

    def __len__(self) -> int:
        """Returns the number of points."""
        return len(self.points)

    def _as_table(self) -> Any:
        return (f"{self.outcome}: conjugate points up to {self.until:g}", ("time", "multiplicity", "gap"),
                [(point.time, point.multiplicity, point.gap) for point in self.points])
