"""The results of calls. Their numpy arrays are views of the bytes received."""
from __future__ import annotations

import enum
import os
from functools import cached_property
from dataclasses import dataclass, field, replace
from typing import Any, Iterator, Mapping, Optional, TypeVar, cast, overload

import numpy as np
from numpy.typing import NDArray

from stiefel import v1 as pb
from stiefel._exports import ccsds, mcap, spice
from stiefel._exports.nodes import Export
from stiefel._given.typed import Scene
from stiefel._results import attitude, save, tables
from stiefel._results.base import Array, ByValue, Ended, Fields, Named, Outcome, Price, RunStatus
from stiefel._results.estimate import Errors, EstimatedError
from stiefel._results.html import Shown
from stiefel._results.kinds import kind_of
from stiefel._results.motion import Motion, motion_of
from stiefel._results.origin import Origin
from stiefel._results.tradeoff import Point, Tradeoff
from stiefel.scene import to_dict

__all__ = ["Batch", "Catalogue", "Choice", "Conservation", "Conversion", "Diagnosis", "Domain", "Errors", "EstimatedError", "Events", "Export", "Geodesic",
           "Invariant", "Motion", "Origin", "Outcome", "Point", "Price", "RunStatus", "State", "Summary", "Tradeoff", "Trajectory"]


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
class Batch(Named):
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
class Trajectory(Ended, Batch):
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
        """Kind, periods, momentum and energy of a rigid body in three dimensions, by the closed form of the exact motion.
        Raises ValueError for another system and for an ensemble."""
        return motion_of(self.scene)

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


class Catalogue(Shown):
    """The systems and methods of a server, with its limits and versions: the fields of stiefel.v1.DescribeResponse, such as
    `systems`, `methods`, `limits`, `version`, `numerics_id` and `build`."""

    def __init__(self, message: pb.DescribeResponse):
        self.message = message  #: the server's reply

    def __getattr__(self, name: str) -> Any:
        if name == "message" or name.startswith("__"):
            raise AttributeError(name)
        return getattr(self.message, name)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Catalogue) and bool(self.message == other.message)

    __hash__ = None  # type: ignore[assignment]

    def _as_table(self) -> Any:
        return (f"stiefel-server {self.version}, numerics id {self.numerics_id}", ("system", "fields", "summary"),
                [(one.name, ", ".join(field.name for field in one.fields), one.summary) for one in self.systems])

    def __repr__(self) -> str:
        systems, methods = (", ".join(one.name for one in those) for those in (self.systems, self.methods))
        return f"<stiefel.Catalogue of version {self.version}\n  systems {systems}\n  methods {methods}>"


@dataclass(frozen=True, repr=False)
class Choice(Shown):
    """A method that the server chose for a scene's tolerance."""

    method: dict[str, Any]  #: the value of "method" in a scene
    tolerance: float
    horizon: float
    reason: str  #: one sentence with error, work, what was measured and which reference it was compared with
    error: float  #: largest error of attitude and momentum up to the horizon; an estimate unless `verified`
    #: Whether the method ran over the whole horizon. False only with "verification": "optional" in the scene.
    verified: bool

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

    def __repr__(self) -> str:
        shapes = ", ".join(f"{name} {values.shape}" for name, values in self.blocks.items())
        what = shapes if self.scene is None else f"a scene of {self.scene['system']}"
        margins = "".join(f", margin of {domain} {margin:.3g}" for domain, margin in self.margins.items())
        return f"<stiefel.Conversion to {what}{margins}>"


@dataclass(frozen=True, eq=False, repr=False)
class Geodesic(Ended, ByValue):
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

    def __repr__(self) -> str:
        frames = "" if self.trajectory is None else f", trajectory {self.trajectory.shape}"
        return (f"<stiefel.Geodesic {self.outcome}: energy {self.energy!r}, residual {self.residual:.1e}, shortest: "
                f"{self.shortest}, {self.distinct} seen{frames}>")


class Conservation(str, enum.Enum):
    """How a method keeps an invariant of the exact motion. Each value equals its name in lower case."""

    EXACT = "exact"  #: kept to rounding, whatever the step
    BOUNDED = "bounded"  #: the error oscillates and does not grow
    DRIFTS = "drifts"  #: the error grows with time
    UNSPECIFIED = "unspecified"  #: the server does not say

    def __str__(self) -> str:
        return self.value

    @classmethod
    def _missing_(cls, value: object) -> Conservation:
        """A number of the enum on the wire, such as `Client.describe` returns."""
        known = isinstance(value, int) and value in pb.Conservation.values()
        return cls(pb.Conservation.Name(value)[len("CONSERVATION_"):].lower()) if known else cls.UNSPECIFIED


@dataclass(frozen=True)
class Invariant(Shown):
    """One number that the exact motion keeps."""

    name: str  #: "energy", "spatial_momentum[0,1]", "manakov[3,1]"
    initial: float
    value: float
    #: |value - initial| / scale, computed before the numbers are rounded to doubles or overflow; |value - initial|
    #: where the scale is 0.
    drift: float
    scale: float  #: the size to which the drift is relative
    conservation: Conservation  #: what the method declares that it does to this invariant
    member: Optional[int] = None  #: in an ensemble: the member with the largest drift, whose numbers these are

    @property
    def of_member(self) -> str:
        """" of member 3" in an ensemble, else ""."""
        return "" if self.member is None else f" of member {self.member}"


@dataclass(frozen=True)
class Domain(Shown):
    """How near the state is to the edge of the map's domain."""

    h_omega: float  #: |h| times the operator norm of Omega
    #: The largest |h| for which a step from this state exists; only for implicit maps and N <= 32.
    largest_step: Optional[float] = None


@dataclass(frozen=True, repr=False)
class Diagnosis(Ended):
    """The properties of the state at `step`. What was not asked for or does not exist is None or empty."""

    step: int
    time: float
    invariants: tuple[Invariant, ...]
    orthogonality: Optional[float]  #: max |Q^T Q - I|; None in momentum-only scenes
    domain: Domain
    forms: tuple[float, ...]  #: the values of the requested two-forms, in their order
    dirac_brackets: tuple[float, ...]  #: the values of the requested brackets, in their order
    #: The largest |omega(T phi u, T phi v) - omega(u, v)| / |u||v| over random pairs, where phi is one step.
    symplectic_defect: Optional[float]
    estimated_error: Optional[EstimatedError]
    run_status: RunStatus
    computed_steps: int = field(compare=False, repr=False)
    #: The families of which `invariants` has only those with the largest drifts, and how many invariants each has.
    shortened: dict[str, int] = field(default_factory=dict)
    price: Optional[Price] = field(default=None, compare=False, repr=False)  #: the predicted price of the call

    def __repr__(self) -> str:
        """Returns three lines; `table` has every invariant."""
        lines = [f"<stiefel.Diagnosis {self.outcome} at step {self.step}, time {self.time!r}: {len(self.invariants)} invariants"]
        kept = []
        if self.invariants:
            worst = max(self.invariants, key=lambda invariant: invariant.drift)
            kept.append(f"largest drift {worst.drift:.1e} of {worst.name}{worst.of_member} ({worst.conservation})")
        if self.orthogonality is not None:
            kept.append(f"orthogonality {self.orthogonality:.1e}")
        if kept:
            lines.append(f"  {', '.join(kept)}")
        if self.estimated_error is not None:
            lines.append(f"  estimated error: {self.estimated_error}")
        return "\n".join(lines) + ">"

    def _as_table(self) -> Any:
        return (f"{self.outcome} at step {self.step}, time {self.time:g}; estimated error: {self.estimated_error or 'not asked for'}",
                ("invariant", "value", "drift", "kept"),
                [(i.name + i.of_member, i.value, i.drift, i.conservation.value) for i in self.invariants])

    def table(self) -> str:
        """Returns a table with one line for each invariant, and the estimated error if it was asked for. A drift says
        nothing about that error. In an ensemble a line names the member whose drift of that invariant is the largest."""
        names = [invariant.name + invariant.of_member for invariant in self.invariants]
        width = max(map(len, names), default=0)
        lines = [f"{self.outcome} at step {self.step}, time {self.time!r}"]
        lines += [f"  {name:{width}}  {i.value:< .12g}  drift {i.drift:.1e}  {i.conservation}"
                  for name, i in zip(names, self.invariants)]
        if self.orthogonality is not None:
            of_all = any(i.member is not None for i in self.invariants)
            lines.append(f"  orthogonality {self.orthogonality:.1e}" + ("  the largest of all members" if of_all else ""))
        if self.estimated_error is not None:
            lines.append(f"  estimated error: {self.estimated_error}")
        return "\n".join(lines)


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
