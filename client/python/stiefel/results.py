"""The results of calls: states and their samples here, and the names of all others. Their numpy arrays are views of the bytes
received."""
from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Iterator, Optional, TypeVar, cast, overload

import numpy as np
from numpy.typing import NDArray

from stiefel._exports import ccsds, spice
from stiefel._exports.nodes import Export
from stiefel._given.attitudes import checked
from stiefel._given.instants import seconds_of, utc_of
from stiefel._given.numbers import refused
from stiefel._given.shown import shown
from stiefel._given.typed import Scene
from stiefel._results import (body, error_against_cost, estimate, geodesics, reduced, save, server_catalogue, state_properties,
                              tables)
from stiefel._results.base import Array, Ended, Fields, Named, Outcome, Price, RunStatus
from stiefel._results.error_against_cost import *  # noqa: F403
from stiefel._results.estimate import *  # noqa: F403
from stiefel._results.geodesics import *  # noqa: F403
from stiefel._results.kinds import kind_of
from stiefel._results.motion import Motion
from stiefel._results.origin import Origin
from stiefel._results.plots import Drawn, Logged
from stiefel._results.reduced import *  # noqa: F403
from stiefel._results.server_catalogue import *  # noqa: F403
from stiefel._results.state_properties import *  # noqa: F403
from stiefel._scene import member_of, to_dict

__all__ = ["Batch", "Export", "Motion", "Origin", "Outcome", "Price", "RunStatus", "State", "Trajectory"]
__dir__ = lambda: sorted(__all__)  # noqa: E731
__all__ += server_catalogue.__all__
__all__ += state_properties.__all__
__all__ += estimate.__all__
__all__ += geodesics.__all__
__all__ += reduced.__all__
__all__ += error_against_cost.__all__


B = TypeVar("B", bound="Batch")
T = TypeVar("T", bound="Trajectory")


@dataclass(frozen=True, eq=False, repr=False)
class State(Ended, Fields):
    """The state at `step`: a mapping from field names to arrays.

    If `outcome` is not REACHED, it is the last good state. A matrix is (rows, cols), a vector (n,), a number (); in an
    ensemble (members,) stands before this shape. The arrays are read-only; `copy()` an array to change it. Two states
    are equal if their steps, times, fields and run statuses are equal, whatever they cost.
    """

    step: int
    time: float
    fields: dict[str, Array]
    run_status: RunStatus
    computed_steps: int = field(default=0, compare=False)  #: steps computed for this reply; earlier states came from a cache
    checkpoint: bytes = field(default=b"", compare=False)  #: on request, a checkpoint that `Client.create` accepts
    work: float = field(default=0.0, compare=False)  #: measured instructions

    def as_rotation(self: Any) -> Any:
        """Returns the attitudes as a `scipy.spatial.transform.Rotation` of body axes to space. Needs `quaternion` or Q."""
        return body.rotation(self.fields, self._side)

    def __repr__(self) -> str:
        return f"<stiefel.State {self.outcome} at step {self.step}, time {self.time!r}: {self._shapes()}>"


@dataclass(frozen=True, eq=False, repr=False)
class Batch(Logged, Named):
    """Consecutive samples, with `step` and `time` of each. `batch["Q"]` is a field at all samples.

    A matrix is (samples, rows, cols), a vector (samples, n), a number (samples,); in an ensemble (members,) stands
    behind the samples. `len` is the number of samples. `batch[i]` is a State and `batch[a:b:c]` a batch of the samples
    of a slice; iterating yields the states. `fields` maps the names to the arrays, and `"Q" in batch` asks for a field.
    """

    step: NDArray[np.int64]
    time: Array
    fields: dict[str, Array]

    @property
    def samples(self) -> int:
        """The number of samples."""
        return len(self.step)

    def __len__(self) -> int:
        """Returns the number of samples."""
        return len(self.step)

    @overload
    def __getitem__(self, which: str) -> Array: ...

    @overload
    def __getitem__(self, which: "int | np.integer[Any]") -> State: ...

    @overload
    def __getitem__(self: B, which: slice) -> B: ...

    def __getitem__(self, which: Any) -> Any:
        if isinstance(which, slice):
            return self._slice(which)
        if isinstance(which, (int, np.integer)) and not isinstance(which, bool):
            if not -len(self) <= which < len(self):
                raise IndexError(f"{which}: there are {len(self)} samples")
            return self._state(range(len(self))[which])
        return self._field(which)

    def __iter__(self) -> Iterator[State]:
        return map(self._state, range(len(self)))

    def _state(self, sample: int) -> State:
        return State(int(self.step[sample]), float(self.time[sample]),
                     {name: values[sample] for name, values in self.fields.items()},
                     self._status_at(sample))._of(self._side)

    def _status_at(self, sample: int) -> RunStatus:
        return RunStatus(Outcome.REACHED)

    def __repr__(self) -> str:
        return f"<stiefel.Batch {self._extent()}: {self._shapes()}>"

    def _extent(self) -> str:
        if not self.samples:
            return "of no samples"
        samples = f"{self.samples} sample" + ("s" if self.samples > 1 else "")
        return f"of {samples}, steps {self.step[0]} to {self.step[-1]}"


@dataclass(frozen=True, eq=False, repr=False)
class Trajectory(Drawn, Ended, Batch):
    """All samples of a run, whose arrays belong to the caller. `run["Q"]` is a field at all samples, `run[i]` the State
    of a sample, and `run[a:b:c]` the trajectory of the samples of a slice; see `Batch` for the shapes.

    Two trajectories are equal if their steps, times, fields and run statuses are equal.
    """

    run_status: RunStatus
    #: Steps computed for the trajectory, including those of streams that broke; other states came from a cache.
    computed_steps: int = field(default=0, compare=False)
    origin: Optional[Origin] = field(default=None, compare=False)  #: scene and build; None if they are not known
    #: That of the last state; None unless `Session.trajectory` was asked for it.
    estimated_error: Optional[EstimatedError] = field(default=None, compare=False)

    @property
    def scene(self) -> Scene:
        """The resolved scene, which gives this trajectory on any server of the same build."""
        scene = to_dict(self._known_origin()._message)
        return cast(Scene, scene if self.epoch is None else {**scene, "epoch": self.epoch})

    @property
    def build(self) -> Optional[str]:
        """The numerics id of the server that computed the samples; builds with the same id compute the same bits."""
        return None if self.origin is None else self.origin.build

    @property
    def epoch(self) -> Optional[str]:
        """The instant of time 0 in ISO 8601; None if the scene has none."""
        return None if self.origin is None else self.origin.epoch

    @property
    def utc(self) -> Optional[NDArray[np.datetime64]]:
        """`time` as instants of UTC to microseconds, in which a leap second reads as the second after it. None without an
        epoch, and for one before 1972 or in another scale of time."""
        return utc_of(self.epoch, self.time)

    @property
    def units(self) -> dict[str, str]:
        """The units of `time` and of those fields for which the scene gives one, which a scene with `body` does."""
        in_si = self.origin is not None and self.origin._message.HasField("body")
        known = {name: kind_of(name).unit for name in self.fields} if in_si else {}
        return {"time": "s", **{name: unit for name, unit in known.items() if unit is not None}}

    @property
    def _side(self) -> Optional[str]:  # type: ignore[override]
        return "" if self.origin is None else self.origin.side

    def _of(self: T, side: Any) -> T:
        return self  # its origin tells it

    def _known_origin(self) -> Origin:
        if self.origin is None:
            raise ValueError("the trajectory does not know its scene: it was made without one")
        return self.origin

    def _status_at(self, sample: int) -> RunStatus:
        return self.run_status if sample == len(self) - 1 else RunStatus(Outcome.REACHED)

    def _slice(self: T, which: slice, **more: Any) -> T:
        """A part that does not end at the last sample is the trajectory of a shorter run, which ended well."""
        if range(len(self))[which][-1:] != range(len(self))[-1:]:
            more = {"run_status": RunStatus(Outcome.REACHED), "estimated_error": None}
        return super()._slice(which, **more)

    @cached_property
    def motion(self) -> Motion:
        """Kind, periods, momentum and energy of a rigid body in three dimensions, in whatever variables, by the closed form
        of the exact motion. The server has them: this makes a session of the scene as `at` does. Raises ValueError for another
        system, and for an ensemble, of which `member` gives one."""
        scene = self.scene
        with self._known_origin().session(scene) as session:
            found: Optional[Motion] = session.diagnose(to=0).motion
        if found is None:
            raise ValueError(f"a closed form is known of one free rigid body in three dimensions: the scene is of {scene['system']}"
                             + "; `member` gives one of its members" * ("members" in scene))
        return found

    @overload
    def at(self, t: float) -> State: ...

    @overload
    def at(self, t: Any) -> "Trajectory": ...

    def at(self, t: Any) -> Any:
        """Returns the state at time `t` of the run's span, or the trajectory of an array of times, as `sol(t)` of SciPy. The
        states are not interpolated: they are those that a run with `times=` gives, and have the fields of this one.

        `t`: seconds, or what `times` takes. It makes a session of the scene at the server of the run, or at that of
        `stiefel.simulate` if the client of the run is closed. Raises InvalidArgument for a time outside of the span.
        """
        origin, seconds = self._known_origin(), np.asarray(seconds_of("t", t, self.epoch), float)
        least, most = (float(end(self.time)) for end in (np.min, np.max)) if len(self) else (np.nan, np.nan)
        outside = seconds[~((least <= seconds) & (seconds <= most))]
        if outside.size or seconds.ndim > 1 or not seconds.size:
            raise refused("t", f"{outside[0] if outside.size else shown(t)}: must be a time, or several, from {least!r} to {most!r}, the span of the run")
        with origin.session(self.scene) as session:
            run: Trajectory = session.trajectory(times=np.atleast_1d(seconds), fields=list(self.fields))
        return run if seconds.ndim else run[0]

    def member(self, member: int) -> "Trajectory":
        """Returns the trajectory of one member of an ensemble: what its scene gives alone with the ensemble's method."""
        origin = self._known_origin()
        if not origin._message.members:
            raise ValueError("the trajectory is of a single motion")
        member, status = range(origin._message.members)[member], self.run_status
        fields = {name: values[:, member] for name, values in self.fields.items()}
        if status.member is not None and status.member != member and all(np.isfinite(one[-1:]).all() for one in fields.values()):
            status = RunStatus(Outcome.REACHED)
        return replace(self, fields=fields, run_status=replace(status, member=None), estimated_error=None,
                       origin=replace(origin, _message=member_of(origin._message, member)))

    as_rotation = State.as_rotation

    def euler_angles(self, sequence: str, *, degrees: bool = False, unwrap: bool = True) -> Array:
        """Returns Euler angles (samples, 3) of the attitude, body to space, in radians. Needs `quaternion` or Q, and SciPy.

        `sequence`: upper case, such as "ZXZ", for axes that turn with the body, Q = Rz(a) Rx(b) Rz(c); lower case for fixed axes.
        `unwrap`: angles are continuous from sample to sample where these are turned by less than half a turn against each other;
        otherwise each is in SciPy's range. Where the first and the third axis are parallel, SciPy warns, and one angle is 0.
        """
        angles = np.asarray(self.as_rotation().as_euler(checked("sequence", sequence)))
        angles = np.unwrap(angles, axis=0) if unwrap else angles
        return np.degrees(angles) if degrees else angles

    def euler_rates(self, sequence: str, *, degrees: bool = False) -> Array:
        """Returns the rates (samples, 3) of the `euler_angles`, in radians a unit of time. They come from the angular velocity,
        not from differences: needs `angular_velocity`, or M in three dimensions. Where the first and the third axis are
        parallel, theirs are not finite."""
        if not body.is_body(self):
            raise ValueError(f"the rates need the field angular_velocity, or M in three dimensions; the fields are {', '.join(self.fields)}")
        rates = body.rates_of_angles(sequence, self.euler_angles(sequence), body.velocities(self.scene, self, None))
        return np.degrees(rates) if degrees else rates

    to_aem, to_ck = ccsds.to_aem, spice.to_ck
    to_xarray, to_dataframe, save = tables.to_xarray, tables.to_dataframe, save.save

    def error_at(self, times: Any = None, *, timeout: Optional[float] = None) -> EstimatedErrors:
        """Returns the estimated errors at times, as `Session.error_at` does; by default at the samples. It makes a session of
        the scene at the server of the run, or at that of `stiefel.simulate` if the client of the run is closed."""
        with self._known_origin().session(self.scene) as session:
            found: EstimatedErrors = session.error_at(self.time if times is None else times, timeout=timeout)
        return found

    def __repr__(self) -> str:
        return f"<stiefel.Trajectory {self.outcome} {self._extent()}: {self._shapes()}>"
