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


@dataclass(frozen=True, repr=False)
class Choice:
    """A method that the server chose for a scene's tolerance."""

    method: dict[str, Any]  #: the value of "method" in a scene
    tolerance: float
    horizon: float
    reason: str  #: one sentence with error, work, what was measured and which reference it was compared with
    error: float  #: largest error of attitude and momentum up to the horizon; an estimate unless `verified`
    #: Whether the method ran over the whole horizon. False only with "verification": "optional" in the scene.
    verified: bool

    @staticmethod
    def of(message: Any) -> Optional[Choice]:
        """Reads the choice in the message of a session or a conversion; None if its scene had no tolerance."""
        if not message.HasField("choice"):
            return None
        choice = message.choice
        method: dict[str, Any] = json_format.MessageToDict(choice.method, preserving_proto_field_name=True)
        return Choice(method, choice.tolerance, choice.horizon, choice.reason, choice.error, choice.verified)

    def __repr__(self) -> str:
        method = ", ".join(f"{name} {value}" if name != "name" else str(value) for name, value in self.method.items())
        return f"<stiefel.Choice of {method} for the tolerance {self.tolerance:g} up to time {self.horizon:g}: {self.reason}>"


@dataclass(frozen=True, eq=False, repr=False)
class Conversion(ByValue):
    """A motion in the variables of another system, as a scene or as blocks."""

    scene: Optional[dict[str, Any]]  #: the resolved scene; None if the target is not a system
    blocks: dict[str, Array]  #: the blocks by name if the target is not a system, else empty
    margins: dict[str, float]  #: distance from the edge of each domain, by the domain's name: positive inside

    choice: Optional[Choice] = None  #: the method that was chosen if the scene had a tolerance

    @staticmethod
    def of(messages: Sequence[pb.ConvertResponse], sent: pb.Scene) -> Conversion:
        """Reads the messages of one call. `sent`: the scene that the call converts."""
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

    def __repr__(self) -> str:
        shapes = ", ".join(f"{name} {values.shape}" for name, values in self.blocks.items())
        what = shapes if self.scene is None else f"a scene of {self.scene['system']}"
        margins = "".join(f", margin of {domain} {margin:.3g}" for domain, margin in self.margins.items())
        return f"<stiefel.Conversion to {what}{margins}>"


@dataclass(frozen=True, eq=False, repr=False)
class Geodesic(ByValue):
    """The geodesic that joins two frames. If `outcome` is not REACHED, none was found."""

    scene: Optional[dict[str, Any]]  #: the scene of the motion from Q_0 at time 0 to Q_T at the given time
    energy: float
    residual: float  #: max |Q(time) - Q_T|
    #: whether it is the shortest geodesic between the frames: "yes" is proved; "none_shorter_found": a search was
    #: completed; "no": a shorter path was seen; "unknown": a search was not completed, or the discrete problem
    shortest: str
    distinct: int  #: how many different geodesics the search has seen
    trajectory: Optional[Array]  #: the frames, (samples + 1, n, N); None without samples
    run_status: RunStatus

    @property
    def outcome(self) -> Outcome:
        return self.run_status.outcome

    @staticmethod
    def of(messages: Sequence[pb.ConnectResponse]) -> Geodesic:
        """Reads all messages of one pair."""
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

    def __repr__(self) -> str:
        frames = "" if self.trajectory is None else f", trajectory {self.trajectory.shape}"
        return (f"<stiefel.Geodesic {self.outcome}: energy {self.energy!r}, residual {self.residual:.1e}, shortest: "
                f"{self.shortest}, {self.distinct} seen{frames}>")


@dataclass(frozen=True)
class EstimatedError:
    """The estimated distance of a state from the exact motion. A drift says nothing about this error."""

    #: max |Q - Q_exact|. None without a frame and where it is too small to tell, below 2 * `reference_error`.
    attitude: Optional[float]
    #: max |M - M_exact| / max |M_exact|. None where it is too small to tell, below 2 * `reference_error`.
    momentum: Optional[float]
    angle: Optional[float]  #: in three dimensions the angle between the attitudes, in radians
    reference_error: float  #: the reference's own error, which attitude and momentum include
    reference: str  #: what the state was compared with
    work: float  #: instructions that the estimate took
    run_work: float  #: instructions that the run from step 0 takes
    missing: str  #: why both attitude and momentum are None, else ""
    member: Optional[int]  #: in an ensemble: the member with the largest error, whose numbers these are

    def __str__(self) -> str:
        """Returns one line: "attitude 4.3e-14, momentum 4.1e-14 from Jacobi's closed form in extended precision"."""
        if self.missing:
            return f"none: {self.missing}"
        known = [f"{name} {value:.1e}" for name, value in (("attitude", self.attitude), ("momentum", self.momentum))
                 if value is not None]
        return f"{', '.join(known) or f'below {2 * self.reference_error:.1e}'} from {self.reference}"

    @staticmethod
    def of(message: pb.EstimatedError) -> EstimatedError:
        def known(name: str) -> Any:
            return getattr(message, name) if message.HasField(name) else None

        return EstimatedError(known("attitude"), known("momentum"), known("angle"), message.reference_error,
                              message.reference, message.work, message.run_work, message.missing, known("member"))
