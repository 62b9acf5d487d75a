"""The resolved scene: the caller's scene with the fields that the server filled in."""
from __future__ import annotations

from contextlib import closing
from typing import TYPE_CHECKING, Any, Iterable, Mapping

import numpy as np

from stiefel import calls
from stiefel import v1 as pb
from stiefel.arrays import Array, decode
from stiefel.assembly import Assembly
from stiefel.checksums import verify_batch
from stiefel.errors import CorruptReply, NotFound, StiefelError, Unavailable
from stiefel.recreation import Recreation, pauses
from stiefel.streams import messages

if TYPE_CHECKING:
    from stiefel.client import Client

_INITIAL, _BODY = "initial.", "body."
_LISTS = (("inertia", "inertia_u", "inertia_v"),  # of a scene
          ("inertia_tensor", "moments", "attitude", "angular_velocity"))  # of its body


def resolve(base: pb.Scene, filled_in: pb.Scene, cleared: Iterable[str], left_out: Iterable[str] = ()) -> pb.Scene:
    """Returns `base`, in which each field of `filled_in` (inside `body`, each of its fields) replaces that of `base`,
    without the fields that `cleared` names. `left_out`: the paths of arrays that `put` will add."""
    scene = pb.Scene()
    scene.CopyFrom(base)
    if filled_in.initial or any(path.startswith(_INITIAL) for path in left_out):
        _clear_blocks(scene)
    for field, _ in filled_in.ListFields():
        if field.name != "body":
            scene.ClearField(field.name)
    for field, _ in filled_in.body.ListFields():
        scene.body.ClearField(field.name)
    scene.MergeFrom(filled_in)
    for name in cleared:
        if name == "initial":
            _clear_blocks(scene)
        elif name in pb.Scene.DESCRIPTOR.fields_by_name:
            scene.ClearField(name)
    return scene


def scene_arrays(client: Client, handle: Recreation, session_id: str) -> dict[str, Array]:
    """Fetches all arrays of the session's resolved scene, by their paths in it. They come before the sample at step 0.
    Begins anew after `handle` had to create the session again."""
    request = pb.StreamRequest(session_id=session_id, scene_arrays=True, checksum=client.checksums)
    deadline, waits, recoveries = calls.Deadline(client.deadline(None)), calls.Pauses(), pauses()
    while True:
        assembly = Assembly()
        stream = client.stub.Stream(request, timeout=deadline.left(), metadata=handle.metadata)
        try:
            with closing(messages(client, handle, stream)) as arriving:
                for message in arriving:
                    if message.steps:
                        return assembly.finish()
                    verify_batch(message, b"", b"", request.checksum)
                    assembly.take(message.scene_arrays)
        except StiefelError as broken:
            error: StiefelError = broken
        try:
            calls.pause_or_raise(error, waits, client, deadline)
        except (NotFound, Unavailable) as lost:
            handle.recover(lost, recoveries, deadline)


def put(arrays: Mapping[str, Array], scene: pb.Scene) -> None:
    """Sets arrays of a scene. Their names are paths in the scene: "initial.Q", "inertia", "body.attitude"."""
    for path, array in arrays.items():
        if path.startswith(_INITIAL):
            block = path[len(_INITIAL):]
            scene.initial_tensors.pop(block, None)
            scene.initial[block].CopyFrom(matrix(array))
            continue
        in_body = path.startswith(_BODY)
        message: Any = scene.body if in_body else scene
        name = path[len(_BODY):] if in_body else path
        if name not in _LISTS[in_body]:
            raise CorruptReply(f"a scene has no array {path}")
        message.ClearField(name)
        getattr(message, name).extend(array.ravel().tolist())


def with_blocks_as_matrices(scene: pb.Scene) -> pb.Scene:
    """Returns the scene with all blocks in `initial` and none in `initial_tensors`."""
    if not scene.initial_tensors:
        return scene
    result = pb.Scene()
    result.CopyFrom(scene)
    for name, tensor in scene.initial_tensors.items():
        result.initial[name].CopyFrom(matrix(decode(tensor)))
    result.ClearField("initial_tensors")
    return result


def matrix(array: Array) -> pb.Matrix:
    """Returns an array as a Matrix, whose rows are all axes of the array but the last. Raises CorruptReply if it has no
    axis."""
    if array.ndim == 0:
        raise CorruptReply("a block of a scene has no axis")
    rows = array.reshape(-1, array.shape[-1])
    imaginary = rows.imag.ravel().tolist() if np.iscomplexobj(rows) else None
    return pb.Matrix(rows=rows.shape[0], cols=rows.shape[1], values=rows.real.ravel().tolist(), imaginary=imaginary)


def _clear_blocks(scene: pb.Scene) -> None:
    scene.ClearField("initial")
    scene.ClearField("initial_tensors")
