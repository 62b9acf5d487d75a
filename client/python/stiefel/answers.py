"""The results of `Client.convert`, `Client.geodesic` and an estimate of the error."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Optional, Sequence

import numpy as np
from google.protobuf import json_format

from stiefel import v1 as pb
from stiefel.arrays import Array, Outcome, RunStatus, name_of
from stiefel.assembly import Assembly
from stiefel.checksums import verify_conversion, verify_geodesic
from stiefel.compare import ByValue
from stiefel.replies import complete, require
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
    def of(messages: Sequence[pb.ConvertResponse], request: pb.ConvertRequest) -> Conversion:
        """Reads the messages of one call."""
        blocks, arrays = Assembly(), Assembly()
        for message in messages:
            verify_conversion(message, request.checksum)
            require(message.continues == (message is not messages[-1]), "a part of the conversion is missing")
            blocks.take(message.blocks)
            arrays.take(message.scene_arrays)
        first, found, scene = complete(messages[0], "price"), arrays.finish(), None
        if first.HasField("scene"):
            resolved = resolve(request.scene, first.scene, first.cleared, found)
            put(found, resolved)
            scene = to_dict(resolved)
        others = blocks.finish()
        require(bool(others) == (scene is None), "a conversion has a scene or blocks")
        require(all(array.dtype.kind in "fc" for array in others.values()), "a block has counts")
        return Conversion(scene, others, {margin.domain: margin.margin for margin in first.margins},
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
    def of(messages: Sequence[pb.ConnectResponse], request: pb.ConnectRequest) -> Geodesic:
        """Reads all messages of one pair."""
        arrays = Assembly()
        for message in messages:
            verify_geodesic(message, request.checksum)
            if message.HasField("trajectory"):
                arrays.take([message.trajectory])
        first = complete(messages[0], "run_status", "price")
        run_status, scene, shortest = RunStatus.of(first.run_status), None, "unspecified"
        trajectory = next(iter(arrays.finish().values()), None)
        require(first.HasField("scene") == (run_status.outcome == Outcome.REACHED), "a geodesic has a scene")
        if first.HasField("scene"):
            scene, shortest = to_dict(first.scene), name_of(pb.Shortest, first.shortest).lower()
            first_frame = request.pairs[first.pair].q_0
            steps = request.steps or request.samples
            asked = (np.dtype(np.float64), (steps + 1, first_frame.rows, first_frame.cols)) if steps else None
            require((trajectory if trajectory is None else (trajectory.dtype, trajectory.shape)) == asked,
                    "the trajectory is not the one that was asked for")
        return Geodesic(scene, first.energy, first.residual, shortest, first.distinct, trajectory, run_status)

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
        of = "" if self.member is None else f", of member {self.member}"
        if self.missing:
            return f"none: {self.missing}{of}"
        known = [f"{name} {value:.1e}" for name, value in (("attitude", self.attitude), ("momentum", self.momentum))
                 if value is not None]
        return f"{', '.join(known) or f'below {2 * self.reference_error:.1e}'} from {self.reference}{of}"

    @staticmethod
    def of(message: pb.EstimatedError) -> EstimatedError:
        def known(name: str) -> Any:
            return getattr(message, name) if message.HasField(name) else None

        return EstimatedError(known("attitude"), known("momentum"), known("angle"), message.reference_error,
                              message.reference, message.work, message.run_work, message.missing, known("member"))
