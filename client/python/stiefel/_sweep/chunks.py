"""Chunks: ensembles of about one second of work. Their sizes never depend on the workers."""
from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Optional

import numpy as np
from numpy.typing import NDArray

from stiefel import v1 as pb
from stiefel._wire.arrays import decode, put_block, to_array
from stiefel._given.shapes import owner_of
from stiefel._sweep.axes import SKEW
from stiefel._sweep.shared_store import Place

WORK = 2.0**34  #: instructions of a chunk, about a second of one core
CREATION = 2.0**20  #: instructions for checking and setting up one member
READING = 2.0**10  #: instructions for reading one quantity of one sample, which a predicted price leaves out
LARGEST = 1 << 14  #: the most members of a chunk
SLOWEST = 100.0  #: a server that takes this many times the predicted time is taken to be lost
KEPT = 1 << 20  #: the most numbers that the quantiles of one call may keep
LANES = 16  #: the number of members of larger chunks is a multiple of this, to fill whole vector registers


def members_of_a_chunk(step_work: float, steps: int, readings: int, kept: int) -> int:
    """Returns how many members make a chunk of about `WORK` instructions whose quantiles keep at most `KEPT` numbers.

    Each member makes `steps` steps of `step_work` instructions, reads `readings` quantities on the way, and its
    quantiles keep `kept` numbers."""
    fit = int(WORK / (step_work * max(steps, 1) + READING * readings + CREATION))
    fit = min(fit, LARGEST, KEPT // kept if kept else LARGEST)
    fit = max(fit, 1)
    return fit - fit % LANES if fit > LANES else fit


@dataclass(frozen=True, eq=False)
class Values:
    """Values of a field that differ between the members of a chunk."""

    field: str  #: the path in the scene
    entry: Optional[tuple[int, ...]]  #: the index of the one number of the field that varies; None for the whole field
    values: NDArray[Any]  #: (members, ...)


@dataclass(frozen=True, eq=False)
class Task:
    """Everything that a worker needs to compute a chunk. A task has the same result on every worker."""

    scene: bytes  #: the scene without the fields that differ between members, as a serialized message
    members: int
    values: tuple[Values, ...]
    request: bytes  #: a serialized SummarizeRequest without a session
    numerics_id: str  #: the numerics id of the build that may compute the task
    index: int = 0  #: the number of the chunk in its sweep
    timeout: float = 600.0  #: seconds after which the server is taken to be lost
    threads: Optional[int] = None  #: threads of the worker's own server
    home: tuple[str, int] = field(default=("", 0))  #: host and process of the sweep
    place: Optional[Place] = None  #: where in the store the worker may write the result, if it sees the store
    #: How often the task failed before. It makes each attempt a different task: Dask would return the remembered
    #: failure.
    attempt: int = 0

    def ensemble(self) -> pb.Scene:
        """Returns the scene of the ensemble of all members."""
        scene: pb.Scene = pb.Scene.FromString(self.scene)
        scene.members = self.members
        own: dict[str, NDArray[Any]] = {}
        for block in {*scene.initial, *scene.initial_tensors}:
            one = to_array(scene.initial[block]) if block in scene.initial else decode(scene.initial_tensors[block])
            own[f"initial.{block}"] = np.broadcast_to(one, (self.members, *one.shape))
        for part in self.values:
            own[part.field] = part.values if part.entry is None else self._with_entry(part, own, scene)
        for path, array in own.items():
            _put(scene, path, array)
        return scene

    def _with_entry(self, part: Values, own: dict[str, NDArray[Any]], scene: pb.Scene) -> NDArray[Any]:
        """Returns a field of all members, (members, ...), with the entry of `part` replaced."""
        if part.field in own:
            array = own[part.field]
        else:
            owner, name = owner_of(scene, part.field)
            array = np.asarray(getattr(owner, name))
        shape = array.shape if part.field in own else (self.members, *array.shape)
        array = np.array(np.broadcast_to(array, shape), dtype=np.result_type(array, part.values))
        entry: tuple[Any, ...] = part.entry or ()
        array[(slice(None), *entry)] = part.values
        if part.field == SKEW:
            array[(slice(None), *entry[::-1])] = -part.values
        return array


def _put(scene: pb.Scene, path: str, array: NDArray[Any]) -> None:
    """Sets a field of all members. `array` is (members, ...)."""
    if path.startswith("initial."):
        put_block(scene, path[len("initial."):], array)
        return
    owner, name = owner_of(scene, path)
    owner.ClearField(name)
    getattr(owner, name).extend(array.ravel().tolist())
