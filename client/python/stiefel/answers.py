"""What Convert, Connect and an estimate of the error answer."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Optional

from stiefel.arrays import Array, RunStatus, Outcome, decode
from stiefel.compare import ByValue
from stiefel.scenes import to_array, to_dict
from stiefel.v1 import simulation_pb2 as pb


@dataclass(frozen=True, eq=False)
class Conversion(ByValue):
    """The same motion in other variables."""

    scene: Optional[dict[str, Any]]  #: resolved; None if what was asked for is not a system
    blocks: dict[str, Array]  #: then instead of it
    margins: dict[str, float]  #: how near a domain's edge, by the domain's name: positive inside

    @staticmethod
    def of(message: pb.ConvertResponse) -> Conversion:
        scene = to_dict(message.scene) if message.HasField("scene") else None
        return Conversion(scene, {name: to_array(block) for name, block in message.blocks.items()},
                          {margin.domain: margin.margin for margin in message.margins})


@dataclass(frozen=True, eq=False)
class Geodesic(ByValue):
    """The geodesic that joins two frames; if `outcome` is not REACHED none was found."""

    scene: Optional[dict[str, Any]]  #: starts at Q_0 and is at Q_T at the time asked for
    energy: float
    residual: float  #: max |Q(time) - Q_T|
    shortest: str  #: "yes", "no" or "unknown"
    distinct: int  #: different geodesics seen
    trajectory: Optional[Array]  #: (samples + 1, n, N), if samples were asked for
    run_status: RunStatus

    @property
    def outcome(self) -> Outcome:
        return self.run_status.outcome

    @staticmethod
    def of(message: pb.ConnectResponse) -> Geodesic:
        scene = to_dict(message.scene) if message.HasField("scene") else None
        shortest = pb.Shortest.Name(message.shortest)[len("SHORTEST_"):].lower()
        trajectory = decode(message.trajectory) if message.HasField("trajectory") else None
        return Geodesic(scene, message.energy, message.residual, shortest, message.distinct, trajectory,
                        RunStatus.of(message.run_status))


@dataclass(frozen=True)
class EstimatedError:
    """How far a state is from the exact motion. Not a drift: that says nothing of the error."""

    attitude: Optional[float]  #: max |Q - Q_exact|; None without a frame or below the reference's error
    momentum: Optional[float]  #: max |M - M_exact| / max |M_exact|; None below the reference's error
    angle: Optional[float]  #: in three dimensions, between the attitudes, radians
    reference_error: float  #: that of the reference itself, which is part of the others
    reference: str  #: what it is measured against
    work: float  #: units of work that it took
    run_work: float  #: and that the run takes
    missing: str  #: why there is neither attitude nor momentum, else ""
    member: Optional[int]  #: of an ensemble: whose error this is, the largest of all

    @staticmethod
    def of(message: pb.EstimatedError) -> EstimatedError:
        def known(name: str) -> Any:
            return getattr(message, name) if message.HasField(name) else None

        return EstimatedError(known("attitude"), known("momentum"), known("angle"), message.reference_error,
                              message.reference, message.work, message.run_work, message.missing, known("member"))
