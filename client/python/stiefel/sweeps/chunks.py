"""Chunks: ensembles of about a second's work. Their sizes depend on the scene alone, never on the workers."""
from __future__ import annotations

import hashlib
from dataclasses import dataclass, field
from typing import Any, Optional

import numpy as np
from numpy.typing import NDArray

from stiefel import v1 as pb
from stiefel.resolved import matrix
from stiefel.scenes import to_array
from stiefel.arrays import decode
from stiefel.sweeps.axes import owner_of
from stiefel.sweeps.shared_store import Place

WORK = 2.0**34  #: instructions of a chunk, about a second of one core
CREATION = 2.0**20  #: instructions for checking and setting up one member
READING = 2.0**10  #: instructions for one quantity of one sample, which a predicted price leaves out
LARGEST = 1 << 14  #: members of a chunk
SLOWEST = 100.0  #: times slower than predicted, when a server is taken to be lost
KEPT = 1 << 20  #: numbers that the quantiles of one call may keep
LANES = 16  #: members that fill whole vector registers


def members_of_a_chunk(step_work: float, steps: int, readings: int, kept: int) -> int:
    """How many members a chunk has, so that its work is about `WORK` instructions and its quantiles keep at most `KEPT`
    numbers. A member makes `steps` steps of `step_work` instructions, reads `readings` quantities on the way, and its
    quantiles keep `kept` numbers."""
    fit = int(WORK / (step_work * max(steps, 1) + READING * readings + CREATION))
    fit = min(fit, LARGEST, KEPT // kept if kept else LARGEST)
    fit = max(fit, 1)
    return fit - fit % LANES if fit > LANES else fit


@dataclass(frozen=True, eq=False)
class Values:
    """The values that the members of a chunk have of their own.

    field: path in the scene; entry: the one number of it that varies, None: all of it; values: (members, ...).
    """

    field: str
    entry: Optional[tuple[int, ...]]
    values: NDArray[Any]


@dataclass(frozen=True, eq=False)
class Task:
    """All that a worker needs. Pure: the same task has the same result on every worker."""

    scene: bytes  #: the scene without what the members have of their own, as a message
    members: int
    values: tuple[Values, ...]
    request: bytes  #: a SummarizeRequest without a session
    numerics_id: str  #: of the build that may compute it
    index: int = 0  #: of the chunk in its sweep
    timeout: float = 600.0  #: seconds after which the server is taken to be lost
    threads: Optional[int] = None  #: of the worker's own server
    home: tuple[str, int] = field(default=("", 0))  #: host and process that the sweep runs in
    place: Optional[Place] = None  #: in a store that the worker may write to, if it sees it
    attempt: int = 0  #: how often it failed before: Dask answers the same task again with the failure that it remembers

    @property
    def key(self) -> str:
        """SHA-256 of what decides the result, not of who computes it."""
        digest = hashlib.sha256()
        for part in (self.scene, str(self.members).encode(), self.request, self.numerics_id.encode()):
            digest.update(len(part).to_bytes(8, "little") + part)
        for one in self.values:
            digest.update(f"{one.field} {one.entry} {one.values.dtype.str} {one.values.shape}\n".encode())
            digest.update(np.ascontiguousarray(one.values).tobytes())
        return digest.hexdigest()

    def ensemble(self) -> pb.Scene:
        """The scene of all its members."""
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
        """The whole field of every member, with one number of it replaced."""
        if part.field in own:
            array = own[part.field]
        else:
            owner, name = owner_of(scene, part.field)
            array = np.asarray(getattr(owner, name))
        shape = array.shape if part.field in own else (self.members, *array.shape)
        array = np.array(np.broadcast_to(array, shape), dtype=np.result_type(array, part.values))
        assert part.entry is not None
        array[(slice(None), *part.entry)] = part.values
        return array


def _put(scene: pb.Scene, path: str, array: NDArray[Any]) -> None:
    """Sets what each member has of its own; `array` is (members, ...)."""
    if path.startswith("initial."):
        block = path[len("initial."):]
        scene.initial.pop(block, None)
        scene.initial_tensors.pop(block, None)
        if array.size <= 4096:
            scene.initial[block].CopyFrom(matrix(array))
            return
        tensor, is_complex = scene.initial_tensors[block], np.iscomplexobj(array)
        tensor.shape.extend(array.shape)
        tensor.data_type = pb.DATA_TYPE_COMPLEX128 if is_complex else pb.DATA_TYPE_FLOAT64
        tensor.data = np.ascontiguousarray(array, "<c16" if is_complex else "<f8").tobytes()
        return
    owner, name = owner_of(scene, path)
    owner.ClearField(name)
    getattr(owner, name).extend(array.ravel().tolist())
