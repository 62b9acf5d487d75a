"""The results of `Client.convert`, `Client.geodesic` and an estimate of the error."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Optional, Sequence

from google.protobuf import json_format

from stiefel import v1 as pb
from stiefel.arrays import Array, Outcome, RunStatus
from stiefel.assembly import Assembly
from stiefel.checksums import verify_conversion, verify_geodesic
from stiefel.compare import ByValue
from stiefel.resolved import put, resolve
from stiefel.scenes import to_dict


@dataclass(frozen=True)
class Choice:
    """A method that the server chose for a scene's tolerance."""

    method: dict[str, Any]  #: as in a scene
    tolerance: float
    horizon: float
    reason: str  #: error, work, what was measured and against what, in one sentence

    @staticmethod
    def of(message: Any) -> Optional[Choice]:
        """Of a session or a conversion; None if its scene named its method."""
        if not message.HasField("choice"):
            return None
        choice = message.choice
        method: dict[str, Any] = json_format.MessageToDict(choice.method, preserving_proto_field_name=True)
        return Choice(method, choice.tolerance, choice.horizon, choice.reason)


@dataclass(frozen=True, eq=False)
class Conversion(ByValue):
    """A motion in other variables."""

    scene: Optional[dict[str, Any]]  #: resolved; None if what was asked for is not a system
    blocks: dict[str, Array]  #: then instead of it
    margins: dict[str, float]  #: how near a domain's edge, by the domain's name: positive inside

    choice: Optional[Choice] = None  #: the method that was chosen if the scene had a tolerance

    @staticmethod
    def of(messages: Sequence[pb.ConvertResponse], sent: pb.Scene) -> Conversion:
        """`sent`: the scene that was to be converted."""
        blocks, arrays = Assembly(), Assembly()
        for message in messages:
            verify_conversion(message)
            blocks.take(message.blocks)
            arrays.take(message.scene_arrays)
        first, found, scene = messages[0], arrays.finish(), None
        if first.HasField("scene"):
            resolved = resolve(sent, first.scene, first.cleared, found)
            put(found, resolved)
            scene = to_dict(resolved)
        return Conversion(scene, blocks.finish(), {margin.domain: margin.margin for margin in first.margins},
                          Choice.of(first))


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
    def of(messages: Sequence[pb.ConnectResponse]) -> Geodesic:
        """`messages`: all of one pair."""
        arrays = Assembly()
        for message in messages:
            verify_geodesic(message)
            if message.HasField("trajectory"):
                arrays.take([message.trajectory])
        first = messages[0]
        scene = to_dict(first.scene) if first.HasField("scene") else None
        shortest = pb.Shortest.Name(first.shortest)[len("SHORTEST_"):].lower()
        trajectory = next(iter(arrays.finish().values()), None)
        return Geodesic(scene, first.energy, first.residual, shortest, first.distinct, trajectory,
                        RunStatus.of(first.run_status))


@dataclass(frozen=True)
class EstimatedError:
    """The estimated distance of a state from the exact motion. A drift says nothing about this error."""

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
