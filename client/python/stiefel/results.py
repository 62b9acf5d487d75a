"""The results of calls. Their numpy arrays are views of the bytes received."""
from __future__ import annotations

import enum
import os
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Iterator, Mapping, Optional, Sequence, TypeVar, cast, overload

import numpy as np
from numpy.typing import NDArray

from stiefel._exports import ccsds, mcap, spice
from stiefel._exports.nodes import Export
from stiefel._given.numbers import numbers
from stiefel._given.typed import Scene
from stiefel._results import attitude, save, tables
from stiefel._results.base import Array, ByValue, Ended, Fields, Named, Outcome, Price, RunStatus
from stiefel._results.catalogue import Catalogue, Choice
from stiefel._results.diagnosis import Conservation, Diagnosis, Domain, Invariant
from stiefel._results.drawn import Drawn, Logged
from stiefel._results.estimate import Errors, EstimatedError
from stiefel._results.html import Shown
from stiefel._results.kinds import kind_of
from stiefel._results.motion import Motion, motion_of
from stiefel._results.origin import Origin
from stiefel._results.tradeoff import Point, Tradeoff
from stiefel.scene import member_of, to_dict

__all__ = ["Batch", "Catalogue", "Choice", "ConjugatePoint", "ConjugatePoints", "Conservation", "Conversion", "Diagnosis", "Domain", "Errors", "EstimatedError", "Events", "Export", "Geodesic",
           "InjectivityRadius", "Invariant", "LyapunovSpectrum", "Motion", "Origin", "Outcome", "Point", "Price", "RunStatus", "Section", "State", "StateTransition", "Summary", "Tradeoff", "Trajectory", "Verdict"]


B = TypeVar("B", bound="Batch")


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
    price: Optional[Price] = field(default=None, compare=False)  #: the predicted price of the computed steps

    def as_rotation(self) -> Any:
        """Returns the attitude as a `scipy.spatial.transform.Rotation` of body axes to space. Needs `quaternion` or Q."""
        return attitude.rotation(self.fields)

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
            return self._part(which)
        if isinstance(which, (int, np.integer)) and not isinstance(which, bool):
            if not -len(self) <= which < len(self):
                raise IndexError(f"{which}: there are {len(self)} samples")
            return self._state(range(len(self))[which])
        return self._field(which)

    def __iter__(self) -> Iterator[State]:
        return map(self._state, range(len(self)))

    def _part(self: B, samples: slice) -> B:
        return replace(self, step=self.step[samples], time=self.time[samples],
                       fields={name: values[samples] for name, values in self.fields.items()})

    def _state(self, sample: int) -> State:
        return State(int(self.step[sample]), float(self.time[sample]),
                     {name: values[sample] for name, values in self.fields.items()}, self._status_at(sample))

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
        scene = to_dict(self._known_origin().scene)
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
    def units(self) -> dict[str, str]:
        """The units of `time` and of those fields for which the scene gives one, which a scene with `body` does."""
        in_si = self.origin is not None and self.origin.scene.HasField("body")
        known = {name: kind_of(name).unit for name in self.fields} if in_si else {}
        return {"time": "s", **{name: unit for name, unit in known.items() if unit is not None}}

    def _known_origin(self) -> Origin:
        if self.origin is None:
            raise ValueError("the trajectory does not know its scene: it was made without one")
        return self.origin

    def _status_at(self, sample: int) -> RunStatus:
        return self.run_status if sample == len(self) - 1 else RunStatus(Outcome.REACHED)

    def _part(self, samples: slice) -> "Trajectory":
        """A part that does not end at the last sample is the trajectory of a shorter run, which ended well."""
        indices = range(len(self))[samples]
        ends_alike = len(indices) > 0 and indices[-1] == len(self) - 1
        return replace(super()._part(samples), run_status=self.run_status if ends_alike else RunStatus(Outcome.REACHED),
                       estimated_error=self.estimated_error if ends_alike else None)

    @cached_property
    def motion(self) -> Motion:
        """Kind, periods, momentum and energy of a rigid body in three dimensions, in whatever variables, by the closed form
        of the exact motion. Raises ValueError for another system, and for an ensemble, of which `member` gives one."""
        return motion_of(self.scene)

    def member(self, member: int) -> "Trajectory":
        """Returns the trajectory of one member of an ensemble: what its scene gives alone with the ensemble's method."""
        origin = self._known_origin()
        if not origin.scene.members:
            raise ValueError("the trajectory is of a single motion")
        member, status = range(origin.scene.members)[member], self.run_status
        fields = {name: values[:, member] for name, values in self.fields.items()}
        if status.member is not None and status.member != member and all(np.isfinite(one[-1:]).all() for one in fields.values()):
            status = RunStatus(Outcome.REACHED)
        return replace(self, fields=fields, run_status=replace(status, member=None), estimated_error=None, origin=Origin(
            member_of(origin.scene, member), origin.build, origin._create, origin.to, origin.times, origin.epoch))

    def as_rotation(self) -> Any:
        """Returns the attitudes as a `scipy.spatial.transform.Rotation` of body axes to space. Needs `quaternion` or Q."""
        return attitude.rotation(self.fields)

    def euler_angles(self, sequence: str, degrees: bool = False) -> Array:
        """Returns Euler angles (samples, 3) of the attitude, body to space. `sequence`: upper case, such as "ZXZ", for axes
        that turn with the body, Q = Rz(a) Rx(b) Rz(c); lower case for fixed axes. Needs `quaternion` or Q."""
        return attitude.euler_angles(self.fields, sequence, degrees)

    def to_aem(self, file: "str | os.PathLike[str]", **options: Any) -> Export:
        """Writes an Attitude Ephemeris Message of CCSDS. Options: `epoch`, the instant of time 0 if the scene has
        none; `object_name`, `object_id`, `center`, `frame`, `body_frame`, `originator`, `created`. The result says how times are rounded and what interpolation loses."""
        return ccsds.to_aem(self, file, **options)

    def to_apm(self, file: "str | os.PathLike[str]", **options: Any) -> Export:
        """Writes an Attitude Parameter Message of CCSDS with the state of one sample: attitude, angular velocity
        and inertia. Options: `at`, the index of the sample, by default the last, and those of `to_aem`."""
        return ccsds.to_apm(self, file, **options)

    def to_ck(self, file: "str | os.PathLike[str]", instrument: int, **options: Any) -> Export:
        """Writes a C-kernel of SPICE and the kernel of its clock, with spiceypy. `instrument`: the code of the body's frame,
        such as -999000. Options: `epoch`, `frame`, `segment`."""
        return spice.to_ck(self, file, instrument=instrument, **options)

    def to_mcap(self, file: "str | os.PathLike[str]", **options: Any) -> Export:
        """Writes an MCAP file with attitude and angular velocity for Foxglove, with the package mcap. Options: `epoch`,
        `frame`, `body_frame`."""
        return mcap.to_mcap(self, file, **options)

    def to_xarray(self) -> Any:
        """Returns an `xarray.Dataset` with the coordinates `time` and `step` and a variable for each field, which has its
        unit; the dataset's attribute `stiefel` says what a file of `save` says."""
        return tables.to_xarray(self)

    def to_dataframe(self) -> Any:
        """Returns a `pandas.DataFrame` with the index `time`, the column `step`, and a column for each number: q_w, omega_x,
        Q[0,0], ...; `attrs` has units and what a file of `save` says."""
        return tables.to_dataframe(self)

    def error_at(self, times: Any = None, timeout: Optional[float] = None) -> Errors:
        """Returns the estimated errors at times, as `Session.error_at` does; by default at the samples. It makes a session of
        the scene at the server of the run, or at that of `stiefel.simulate` if the client of the run is closed."""
        with self._known_origin().session(self.scene) as session:
            found: Errors = session.error_at(self.time if times is None else times, timeout)
        return found

    def save(self, file: "str | os.PathLike[str]") -> None:
        """Writes the samples in the format that the extension of the name chooses; `stiefel.load` reads them.

        .npz: `step`, `time` and the fields by name, for `numpy.load`. .csv: one line per sample. .json: the samples by step.
        .h5, .zarr, .parquet: the same with h5py, zarr and pyarrow. Every file has the resolved scene, the build, the outcome
        and the estimated error, and `stiefel rerun FILE` computes its samples again. Raises ValueError for another
        extension. The file appears under its name only when it is complete.
        """
        save.save(self, file)

    def __repr__(self) -> str:
        return f"<stiefel.Trajectory {self.outcome} {self._extent()}: {self._shapes()}>"


@dataclass(frozen=True, eq=False, repr=False)
class Conversion(ByValue):
    """A motion in the variables of another system, as a scene or as blocks."""

    scene: Optional[dict[str, Any]]  #: the resolved scene; None if the target is not a system
    blocks: dict[str, Array]  #: the blocks by name if the target is not a system, else empty
    margins: dict[str, float]  #: distance from the edge of each domain, by the domain's name: positive inside

    choice: Optional[Choice] = None  #: the method that was chosen if the scene had a tolerance

    def __repr__(self) -> str:
        shapes = ", ".join(f"{name} {values.shape}" for name, values in self.blocks.items())
        what = shapes if self.scene is None else f"a scene of {self.scene['system']}"
        margins = "".join(f", margin of {domain} {margin:.3g}" for domain, margin in self.margins.items())
        return f"<stiefel.Conversion to {what}{margins}>"


@dataclass(frozen=True, eq=False, repr=False)
class Geodesic(Ended, ByValue):
    """The geodesic that joins two frames. If `outcome` is not REACHED, none was found."""

    #: the scene of the motion from Q_0 at time 0 to Q_T at the given time; None where it was not asked for, and in a metric
    #: that no Lambda has
    scene: Optional[dict[str, Any]]
    velocity: Optional[Array]  #: Qdot at Q_0; None for the discrete problem
    energy: float
    residual: float  #: max |Q(time) - Q_T|
    #: whether it is the shortest geodesic between the frames: "yes" is proved; "none_shorter_found": a search was
    #: completed; "no": a shorter path was seen; "unknown": a search was not completed, or the discrete problem
    shortest: str
    distinct: int  #: how many different geodesics the search has seen
    trajectory: Optional[Array]  #: the frames, (samples + 1, n, N); None without samples
    run_status: RunStatus

    def __repr__(self) -> str:
        frames = "" if self.trajectory is None else f", trajectory {self.trajectory.shape}"
        return (f"<stiefel.Geodesic {self.outcome}: energy {self.energy!r}, residual {self.residual:.1e}, shortest: "
                f"{self.shortest}, {self.distinct} seen{frames}>")


@dataclass(frozen=True, eq=False, repr=False)
class ConjugatePoint(ByValue):
    """A time at which the differential of the exponential map, from velocities at time 0 to frames, is singular."""

    time: float
    multiplicity: int
    kernel: Array  #: (multiplicity, n, N): changes of Qdot(0) that do not change Q(time), orthonormal in the metric
    gap: Optional[float]  #: sin(theta) of the next field, tan(theta) = |J| / (t |DJ/dt|); None if there is none

    def __repr__(self) -> str:
        return f"<stiefel.ConjugatePoint at {self.time!r}, multiplicity {self.multiplicity}>"


@dataclass(frozen=True, eq=False, repr=False)
class ConjugatePoints(Ended, ByValue, Sequence[ConjugatePoint]):
    """The conjugate points along a geodesic, in the order of their times."""

    points: tuple[ConjugatePoint, ...]
    until: float  #: every conjugate point up to this time is here: `time`, or less if `outcome` is not REACHED
    run_status: RunStatus
    price: Optional[Price] = field(default=None, compare=False)

    @overload
    def __getitem__(self, index: int) -> ConjugatePoint: ...
    @overload
    def __getitem__(self, index: slice) -> tuple[ConjugatePoint, ...]: ...
    def __getitem__(self, index: Any) -> Any:
        return self.points[index]

    def __len__(self) -> int:
        """Returns the number of points."""
        return len(self.points)

    def __repr__(self) -> str:
        return f"<stiefel.ConjugatePoints {self.outcome}: {len(self)} up to {self.until!r}>"


@dataclass(frozen=True, eq=False, repr=False)
class InjectivityRadius(Ended, ByValue):
    """Bounds of the injectivity radius of V(n, N), in lengths of the metric, and how the search went."""

    upper: float  #: the least that was found: a distance to a conjugate point, or half the length of a closed geodesic
    lower: float  #: a proven lower bound; 0 where there is none
    witness: str  #: what shows `upper`: "conjugate_point" or "closed_geodesic"
    Q: Array  #: the geodesic of unit speed that shows `upper`, (n, N)
    Qdot: Array
    residual: float  #: |J| / (t |DJ/dt|) at the conjugate point, or the largest difference between the ends of the closed geodesic
    least_conjugate: Optional[float]  #: the least distance to a conjugate point that was found; None if none was
    least_loop: float  #: half the length of the shortest closed geodesic that was found
    starts: int  #: geodesics from which the search descended
    agreeing: int  #: how many of them ended within 1e-6 of `least_conjugate`
    loops: int  #: closed geodesics that were found
    run_status: RunStatus

    def __repr__(self) -> str:
        return (f"<stiefel.InjectivityRadius {self.outcome}: {self.lower!r} to {self.upper!r} ({self.witness}), "
                f"{self.agreeing} of {self.starts} descents agree>")


@dataclass(frozen=True, eq=False, repr=False)
class Events(Named):
    """Zeros of functions of the state, ordered by step. `events["Q"]` is a field at all zeros, `len` the number of zeros,
    and `events[a:b:c]` has those of a slice. Events are equal if all their arrays and their run statuses are equal."""

    event: NDArray[np.uint32]  #: the index of the event among those asked for
    step: NDArray[np.int64]  #: the last step before the zero
    #: The zero is at step + fraction, 0 < fraction <= 1. For a discrete system the fraction is 1, and the zero lies
    #: somewhere between the two steps.
    fraction: Array
    time: Array  #: (step + fraction) times the scene's step
    member: Optional[NDArray[np.uint32]]  #: the member of an ensemble; None for a single motion
    fields: dict[str, Array]  #: the fields at the zeros: (events, rows, cols), a vector (events, n), a number (events,)
    run_status: Optional[RunStatus] = None  #: how the run ended; None in the parts from `Session.stream_events`

    @property
    def count(self) -> int:
        """The number of zeros."""
        return len(self.step)

    def __len__(self) -> int:
        """Returns the number of zeros."""
        return len(self.step)

    @overload
    def __getitem__(self, which: str) -> Array: ...

    @overload
    def __getitem__(self, which: slice) -> Events: ...

    def __getitem__(self, which: Any) -> Any:
        if not isinstance(which, slice):
            return self._field(which)
        return Events(self.event[which], self.step[which], self.fraction[which], self.time[which],
                      None if self.member is None else self.member[which],
                      {name: values[which] for name, values in self.fields.items()}, self.run_status)

    def __iter__(self) -> Iterator[Events]:
        """Yields each zero as events of length 1."""
        return (self[k:k + 1] for k in range(len(self)))

    def __repr__(self) -> str:
        outcome = f" {self.run_status.outcome}" if self.run_status else ""
        return f"<stiefel.Events{outcome} of {self.count} zero{'s' if self.count != 1 else ''}: {self._shapes()}>"


@dataclass(frozen=True, eq=False, repr=False)
class Section(Events):
    """The crossings of a plane in the space of states, from `Session.poincare`, ordered by step."""

    points: Array = field(default_factory=lambda: np.empty((0, 0)))  #: (crossings, coordinates)
    residual: Array = field(default_factory=lambda: np.empty(0))  #: how far the reported state is from the plane: g at the crossing

    @overload
    def __getitem__(self, which: str) -> Array: ...

    @overload
    def __getitem__(self, which: slice) -> Section: ...

    def __getitem__(self, which: Any) -> Any:
        part = super().__getitem__(which)
        return part if isinstance(which, str) else Section(
            part.event, part.step, part.fraction, part.time, part.member, part.fields, part.run_status, self.points[which],
            self.residual[which])

    def __repr__(self) -> str:
        return super().__repr__().replace("Events", "Section").replace(" zero", " crossing")


@dataclass(frozen=True, eq=False, repr=False)
class StateTransition(Ended, ByValue):
    """The derivative of the computed steps, from `Session.state_transition`.

    Column k of `matrix`, (d, m), is what became of vector k, in the coordinates at `step`; behind these columns stand
    those of the `parameters`. With `every` the results stand along a first axis of `step`, `time`, `matrix`, `vectors`
    and `basis`.

    Coordinates of a body (Q, M): eta, then dM, with dQ = Q eta, for a right-invariant one dQ = eta Q; for N = 3 as axial
    vectors (x, y, z), otherwise the elements i < j row by row. Of other states: those of the orthonormal `basis`.
    """

    step: Any  #: the step, or (results,) the steps
    time: Any  #: in seconds
    matrix: Optional[Array]  #: (d, m); None where the vectors were given as blocks
    vectors: Optional[Array]  #: (m, rows, cols), where they were given as blocks
    basis: Optional[Array]  #: (d, rows, cols): element k is the vector with the coordinate k equal to 1, blocks stacked
    start_basis: Optional[Array]  #: the same at the state where the vectors start
    parameters: tuple[str, ...]  #: "inertia", with a column for each lambda; "step", with one
    run_status: RunStatus
    computed_steps: int = field(default=0, compare=False)
    price: Optional[Price] = field(default=None, compare=False)

    def gradient(self, slope: Any) -> Array:
        """Returns the derivatives of a scalar of the last state by the start's coordinates and by the parameters, in the
        order of the columns. `slope`: the derivatives of the scalar by the last state's coordinates, (d)."""
        if self.matrix is None:
            raise TypeError("the vectors were given as blocks: their matrix is not known")
        last = self.matrix if self.matrix.ndim == 2 else self.matrix[-1]
        return np.asarray(numbers("slope", slope) @ last)

    def __repr__(self) -> str:
        array = self.matrix if self.matrix is not None else self.vectors
        shape = array.shape if array is not None else ()
        return f"<stiefel.StateTransition {self.outcome} of the shape {shape}>"


class Verdict(str, enum.Enum):
    """What the growth of tangent vectors says of a motion."""

    UNDECIDED = "undecided"
    REGULAR = "regular"
    CHAOTIC = "chaotic"

    def __str__(self) -> str:
        return self.value


@dataclass(frozen=True, eq=False, repr=False)
class LyapunovSpectrum(Ended, ByValue):
    """Lyapunov exponents, from `Session.lyapunov`: how fast neighbouring motions part.

    A tangent vector (dQ, dM) is measured by |dQ|^2 + n |dM|^2 / |M|^2, with the norms of the blocks at the start.
    t lambda(t) grows like ln t where a motion is regular, and in proportion to t where it is chaotic.
    """

    exponents: Array  #: (k,), in 1/time, in the order of the vectors: the largest first, up to the errors
    errors: Array  #: (k,), half-widths of 95 % intervals: batch means, and what growth by a factor t contributes
    verdict: Verdict
    reason: str  #: why, in words and numbers
    log_gali: Array  #: (k - 1,), ln GALI_2 ... ln GALI_k, which have no floor
    step: int  #: where the exponents end
    time: float
    steps: Array  #: (r,), of the numbers on the way, the last ones included
    times: Array  #: (r,), from step 0 of the scene
    history: Array  #: (r, k), exponents over the time from the start to there
    log_gali_history: Array  #: (r, k - 1)
    interval: int  #: steps between two orthonormalisations
    run_status: RunStatus
    checkpoint: bytes = field(default=b"", compare=False)  #: from which a later call goes on
    checkpoint_ignored: bool = field(default=False, compare=False)  #: whether the server did not have the key of the given one
    computed_steps: int = field(default=0, compare=False)
    price: Optional[Price] = field(default=None, compare=False)

    @property
    def gali(self) -> Array:
        """GALI_2 ... GALI_k: the volumes of the first j vectors, each of length 1 but not orthonormalised."""
        return np.asarray(np.exp(self.log_gali))

    def __repr__(self) -> str:
        largest = f", largest exponent {self.exponents[0]:.3g}" if len(self.exponents) else ""
        error = f" +- {self.errors[0]:.2g}" if len(self.errors) else ""
        return f"<stiefel.LyapunovSpectrum {self.verdict}{largest}{error}>"


@dataclass(frozen=True, eq=False, repr=False)
class Summary(Ended, ByValue, Mapping[str, "dict[str, Array]"]):
    """Statistics by quantity and name: `summary["energy"]["drift"]`. Two summaries are equal if all their arrays and their
    run statuses are equal, whatever they cost.

    The shape of an array is that of the field, () for a single invariant, or (invariants,) for a family. In an
    ensemble, (members,) stands before this shape; (quantiles,) or (bins,) stands behind it.
    """

    quantities: dict[str, dict[str, Array]]
    outcomes: Array  #: how each motion ended, texts equal to `Outcome`: (), in an ensemble (members,)
    last_step: Array  #: the last step of each motion: (), in an ensemble (members,)
    ended_by: Array  #: the index of the terminal event, or -1: (), in an ensemble (members,)
    samples: Array  #: the number of samples: (), in an ensemble (members,)
    run_status: RunStatus
    computed_steps: int = field(compare=False)
    price: Optional[Price] = field(default=None, compare=False)
    checkpoint: bytes = field(default=b"", compare=False)  #: the last checkpoint, if any was asked for
    #: whether the server ignored the call's checkpoint, because it does not have the key that signed it
    checkpoint_ignored: bool = field(default=False, compare=False)

    def __getitem__(self, name: str) -> dict[str, Array]:
        try:
            return self.quantities[name]
        except KeyError:
            raise KeyError(f"no quantity {name!r}; the quantities are {', '.join(self.quantities) or 'none'}") from None

    def __contains__(self, name: object) -> bool:
        return name in self.quantities

    def _ipython_key_completions_(self) -> list[str]:
        return list(self.quantities)

    def __iter__(self) -> Any:
        return iter(self.quantities)

    def __len__(self) -> int:
        return len(self.quantities)

    def _as_table(self) -> Any:
        return (f"{self.outcome}", ("quantity", "statistic", "value"),
                [(name, statistic, values) for name, found in self.quantities.items() for statistic, values in found.items()])

    def __repr__(self) -> str:
        what = ", ".join(f"{name} {'/'.join(statistics)}" for name, statistics in self.quantities.items())
        return f"<stiefel.Summary {self.outcome}: {what or 'nothing'}>"
