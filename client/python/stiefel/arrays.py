"""States and trajectories. Their numpy arrays are views of the bytes received."""
from __future__ import annotations

import enum
import math
import os
from dataclasses import dataclass, field
from typing import Any, Iterable, Iterator, Mapping, Optional

import numpy as np
from numpy.typing import NDArray

from stiefel import save
from stiefel import v1 as pb
from stiefel.compare import ByValue
from stiefel.errors import CorruptReply

Array = NDArray[Any]  # float64, complex128, or float32 in a scene whose scalar is "float"
DTYPES: dict[int, np.dtype[Any]] = {
    pb.DATA_TYPE_FLOAT64: np.dtype("<f8"), pb.DATA_TYPE_COMPLEX128: np.dtype("<c16"),
    pb.DATA_TYPE_FLOAT32: np.dtype("<f4"), pb.DATA_TYPE_INT64: np.dtype("<i8"),
}
_STEP, _TIME = "step", "time"


class Outcome(str, enum.Enum):
    """How a run ended. Anything but REACHED is a numerical stop with the last good state."""

    REACHED = "REACHED"
    LEFT_DOMAIN = "LEFT_DOMAIN"
    SOLVER_STALLED = "SOLVER_STALLED"
    NOT_FINITE = "NOT_FINITE"
    CANCELLED = "CANCELLED"

    def __str__(self) -> str:
        return self.value


@dataclass(frozen=True)
class RunStatus:
    """How a run ended, with the reason."""

    outcome: Outcome
    #: For LEFT_DOMAIN: the largest |h| with which all substeps of the next step have a solution, or None.
    largest_step: Optional[float] = None
    message: str = ""  #: the reason in one sentence; empty when REACHED
    #: In an ensemble: the member that stopped first, counted from 0.
    member: Optional[int] = None

    @staticmethod
    def of(message: pb.RunStatus) -> RunStatus:
        name = name_of(pb.Outcome, message.outcome)
        largest = message.largest_step if message.HasField("largest_step") else None
        member = message.member if message.HasField("member") else None
        return RunStatus(Outcome(name), largest, message.message, member)


@dataclass(frozen=True)
class Price:
    """The cost of a call, predicted before it runs."""

    work: float  #: instructions
    bytes: int  #: bytes of the reply's arrays
    #: "expected"; "at_least" if a part of the work cannot be predicted; "at_most" if the call stops at this work.
    bound: str

    @staticmethod
    def of(message: pb.Price) -> Price:
        return Price(message.work, message.bytes, name_of(pb.PriceBound, message.bound).lower())


class Fields(ByValue, Mapping[str, Array]):
    """A mapping from field names to arrays: `state["Q"]`."""

    fields: dict[str, Array]

    def __getitem__(self, name: str) -> Array:
        try:
            return self.fields[name]
        except KeyError:
            there = ", ".join(self.fields) or "none"
            raise KeyError(f"no field {name!r}; the fields are {there}, or those that `fields` names") from None

    def __contains__(self, name: object) -> bool:
        return name in self.fields

    def __iter__(self) -> Iterator[str]:
        return iter(self.fields)

    def __len__(self) -> int:
        """Returns the number of fields."""
        return len(self.fields)

    def _ipython_key_completions_(self) -> list[str]:
        return list(self.fields)

    def _shapes(self) -> str:
        return ", ".join(f"{name} {values.shape}" for name, values in self.fields.items()) or "no fields"


@dataclass(frozen=True, eq=False, repr=False)
class State(Fields):
    """The state at `step`: a mapping from field names to arrays.

    If `outcome` is not REACHED, it is the last good state. The arrays are (rows, cols), in an ensemble (members, rows,
    cols). They are read-only; `copy()` an array to change it. Two states are equal if their steps, times, fields and
    run statuses are equal, whatever they cost.
    """

    step: int
    time: float
    fields: dict[str, Array]
    run_status: RunStatus
    computed_steps: int = field(compare=False)  #: steps computed for this reply; earlier states came from a cache
    checkpoint: bytes = field(compare=False)  #: on request, a checkpoint that `Client.create` accepts
    price: Optional[Price] = field(default=None, compare=False)  #: the predicted price of the computed steps

    @property
    def outcome(self) -> Outcome:
        return self.run_status.outcome

    @staticmethod
    def of(message: pb.StepResponse, fields: dict[str, Array]) -> State:
        """Reads a message. `fields`: those of its sample."""
        sample = message.sample
        return State(sample.step, sample.time, fields, RunStatus.of(message.run_status),
                     message.computed_steps, message.checkpoint, Price.of(message.price))

    def __repr__(self) -> str:
        return f"<stiefel.State {self.outcome} at step {self.step}, time {self.time!r}: {self._shapes()}>"


@dataclass(frozen=True, eq=False, repr=False)
class Batch(Fields):
    """Consecutive samples: a mapping from field names to arrays, with `step` and `time` of every sample.

    The arrays are (samples, rows, cols), in an ensemble (samples, members, rows, cols).
    """

    step: NDArray[np.int64]
    time: Array
    fields: dict[str, Array]

    @property
    def samples(self) -> int:
        """The number of samples."""
        return len(self.step)

    def __repr__(self) -> str:
        return f"<stiefel.Batch {self._extent()}: {self._shapes()}>"

    def _extent(self) -> str:
        if not self.samples:
            return "of no samples"
        samples = f"{self.samples} sample" + ("s" if self.samples > 1 else "")
        return f"of {samples}, steps {self.step[0]} to {self.step[-1]}"


@dataclass(frozen=True, eq=False, repr=False)
class Trajectory(Batch):
    """All samples of a run: a mapping from field names to arrays, which belong to the caller.

    Two trajectories are equal if their steps, times, fields and run statuses are equal.
    """

    run_status: RunStatus
    #: Steps computed for the trajectory, including those of streams that broke; other states came from a cache.
    computed_steps: int = field(compare=False)

    @property
    def outcome(self) -> Outcome:
        return self.run_status.outcome

    def save(self, file: "str | os.PathLike[str]") -> None:
        """Writes the samples in a format of `stiefel run --output`, which the extension of the name chooses.

        .npz: `step`, `time` and the fields by name, for `numpy.load`. .csv: one line per sample. .json: the samples
        and the outcome. Raises ValueError for another extension. The file appears under its name only when it is
        complete.
        """
        save.save(self, file)

    def __repr__(self) -> str:
        return f"<stiefel.Trajectory {self.outcome} {self._extent()}: {self._shapes()}>"


def read_steps(message: pb.StreamResponse, every: int) -> NDArray[np.int64]:
    """Returns the steps of a message with samples.

    Equally spaced steps are generated from the first and the last one, because reading repeated numbers one by one
    would cost more than all the fields together. For the same reason the caller computes the times as k · step, which
    gives the engine's bits.
    """
    first, last, count = message.steps[0], message.steps[-1], len(message.steps)
    if last - first == every * (count - 1):
        return np.arange(first, last + 1, every)
    return np.fromiter(message.steps, np.int64, count)


class Collector:
    """Joins batches in arrays that are allocated once, for at most `count` samples."""

    def __init__(self, count: int):
        self._count = count
        self._done = 0
        self._arrays: dict[str, NDArray[Any]] = {}

    def add(self, batch: Batch) -> None:
        end = self._done + batch.samples
        for name, part in {_STEP: batch.step, _TIME: batch.time, **batch.fields}.items():
            if name not in self._arrays:
                self._arrays[name] = np.empty((self._count, *part.shape[1:]), part.dtype)
            self._arrays[name][self._done:end] = part
        self._done = end

    def trajectory(self, run_status: RunStatus, computed_steps: int) -> Trajectory:
        """Returns all samples that were added."""
        fields = {name: values[:self._done] for name, values in self._arrays.items()}
        step, time = fields.pop(_STEP, np.empty(0, np.int64)), fields.pop(_TIME, np.empty(0))
        return Trajectory(step, time, fields, run_status, computed_steps)


def decode(tensor: pb.Tensor) -> Array:
    """Returns a read-only view of the tensor's bytes. Raises CorruptReply if they are not as many as the shape says."""
    dtype = dtype_of(tensor)
    if len(tensor.data) != dtype.itemsize * math.prod(tensor.shape):
        raise CorruptReply(f"an array of the shape {tuple(tensor.shape)} has {len(tensor.data)} bytes")
    array: Array = np.frombuffer(tensor.data, dtype).reshape(tensor.shape)
    return array


def dtype_of(tensor: pb.Tensor) -> np.dtype[Any]:
    try:
        return DTYPES[tensor.data_type]
    except KeyError:
        raise CorruptReply(f"an array has the unknown data type {tensor.data_type}") from None


def name_of(kind: Any, value: int) -> str:
    """Returns the name of an enum's value without its prefix, which is the name of the value 0 without UNSPECIFIED: "REACHED"
    for OUTCOME_REACHED. Raises CorruptReply for the value 0 and for an unknown one."""
    if value == 0 or value not in kind.values():
        raise CorruptReply(f"the reply breaks the protocol: {kind.DESCRIPTOR.name} {value}")
    return str(kind.Name(value))[len(kind.Name(0)) - len("UNSPECIFIED"):]


def decode_fields(fields: Iterable[pb.Field]) -> dict[str, Array]:
    return {field.name: decode(field.value) for field in fields}
