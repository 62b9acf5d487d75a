"""What comes back: numpy arrays that are views of the bytes received."""
from __future__ import annotations

import enum
import os
from dataclasses import dataclass
from typing import Any, Iterable, Optional

import numpy as np
from numpy.typing import NDArray

from stiefel.v1 import outcome_pb2, scene_pb2, simulation_pb2

Array = NDArray[Any]  # float64, or complex128
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
class Ending:
    outcome: Outcome
    #: LEFT_DOMAIN: the largest |h| that has a solution from the last good state.
    largest_step: Optional[float] = None
    message: str = ""
    #: Of an ensemble: the member that ended it, from 0.
    member: Optional[int] = None

    @staticmethod
    def of(message: outcome_pb2.Ending) -> Ending:
        name = outcome_pb2.Outcome.Name(message.outcome)
        largest = message.largest_step if message.HasField("largest_step") else None
        member = message.member if message.HasField("member") else None
        return Ending(Outcome(name[len("OUTCOME_"):]), largest, message.message, member)


class _Fields:
    """Anything with `fields`, read as `thing["Q"]`."""

    fields: dict[str, Array]

    def __getitem__(self, name: str) -> Array:
        return self.fields[name]


@dataclass(frozen=True)
class State(_Fields):
    """The state at `step`, each field (rows, cols), of an ensemble (members, rows, cols); the last good one if `outcome` is not REACHED."""

    step: int
    time: float
    fields: dict[str, Array]
    ending: Ending
    computed_steps: int  #: the steps computed for this reply; the rest came from a cache
    checkpoint: bytes  #: what `Client.create` accepts, if it was asked for

    @property
    def outcome(self) -> Outcome:
        return self.ending.outcome

    @staticmethod
    def of(message: simulation_pb2.StepResponse) -> State:
        sample = message.sample
        return State(sample.step, sample.time, decode_fields(sample.fields), Ending.of(message.ending),
                     message.computed_steps, message.checkpoint)


@dataclass(frozen=True)
class Batch(_Fields):
    """Consecutive samples: every field is (samples, rows, cols), of an ensemble (samples, members, rows, cols)."""

    step: NDArray[np.int64]
    time: Array
    fields: dict[str, Array]

    def __len__(self) -> int:
        return len(self.step)

    @staticmethod
    def of(message: simulation_pb2.StreamResponse, every: int, step: float) -> Batch:
        """`every` and `step` (the scene's) are what the request asked for.

        Reading repeated numbers one by one would cost more than all the fields together, so where the
        steps are equally spaced they are counted, and the times are k · step, as in the engine.
        """
        first, last, count = message.steps[0], message.steps[-1], len(message.steps)
        if last - first == every * (count - 1):
            steps = np.arange(first, last + 1, every)
        else:
            steps = np.fromiter(message.steps, np.int64, count)
        return Batch(steps, steps * step, decode_fields(message.fields))


@dataclass(frozen=True)
class Trajectory(Batch):
    """All samples of a run."""

    ending: Ending
    computed_steps: int

    @property
    def outcome(self) -> Outcome:
        return self.ending.outcome

    def save(self, file: "str | os.PathLike[str]") -> None:
        """Writes an .npz with `step`, `time` and the fields by name."""
        np.savez_compressed(file, step=self.step, time=self.time, **self.fields)


class Collector:
    """Puts batches into arrays that are allocated once, for `count` samples."""

    def __init__(self, count: int):
        self._count = count
        self._done = 0
        self._arrays: dict[str, NDArray[Any]] = {}

    def add(self, batch: Batch) -> None:
        end = self._done + len(batch)
        for name, part in {_STEP: batch.step, _TIME: batch.time, **batch.fields}.items():
            if name not in self._arrays:
                self._arrays[name] = np.empty((self._count, *part.shape[1:]), part.dtype)
            self._arrays[name][self._done:end] = part
        self._done = end

    def trajectory(self, last: simulation_pb2.StreamResponse) -> Trajectory:
        """What was added, with the ending that the last message tells."""
        fields = {name: values[:self._done] for name, values in self._arrays.items()}
        step, time = fields.pop(_STEP, np.empty(0, np.int64)), fields.pop(_TIME, np.empty(0))
        return Trajectory(step, time, fields, Ending.of(last.ending), last.computed_steps)


def decode(tensor: scene_pb2.Tensor) -> Array:
    """A read-only view of the tensor's bytes."""
    dtype = "<c16" if tensor.data_type == scene_pb2.DATA_TYPE_COMPLEX128 else "<f8"
    return np.frombuffer(tensor.data, dtype=dtype).reshape(tensor.shape)


def decode_fields(fields: Iterable[simulation_pb2.Field]) -> dict[str, Array]:
    return {field.name: decode(field.value) for field in fields}
