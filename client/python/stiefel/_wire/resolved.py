"""The resolved scene: the caller's scene with the fields that the server filled in."""
from __future__ import annotations

from contextlib import closing
from typing import Iterable, Mapping

from stiefel import v1 as pb
from stiefel._given.shapes import LISTS, owner_of
from stiefel._results.base import Array
from stiefel._wire.arrays import Assembly, decode, matrix, put_block
from stiefel._wire.recreating import Attempts, Recreation
from stiefel.errors import CorruptReply, StiefelError

_INITIAL = "initial."


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


def scene_arrays(handle: Recreation, session_id: str) -> dict[str, Array]:
    """Fetches all arrays of the session's resolved scene, by their paths in it. They come before the sample at step 0.
    Begins anew after `handle` had to create the session again."""
    request = pb.StreamRequest(session_id=session_id, scene_arrays=True)
    attempts = Attempts(handle, handle.connection.deadline(None), late=False)
    while True:
        assembly = Assembly()
        try:
            with closing(handle.messages("Stream", request, attempts.deadline.left())) as arriving:
                for message in arriving:
                    if message.steps:
                        return assembly.finish()
                    assembly.take(message.scene_arrays)
        except StiefelError as error:
            attempts.again(error)


def put(arrays: Mapping[str, Array], scene: pb.Scene) -> None:
    """Sets arrays of a scene. Their names are paths in the scene: "initial.Q", "inertia", "body.attitude"."""
    for path, array in arrays.items():
        if path.startswith(_INITIAL):
            put_block(scene, path[len(_INITIAL):], array)
            continue
        if path not in LISTS:
            raise CorruptReply(f"a scene has no array {path}")
        owner, name = owner_of(scene, path)
        owner.ClearField(name)
        getattr(owner, name).extend(array.ravel().tolist())


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


def _clear_blocks(scene: pb.Scene) -> None:
    scene.ClearField("initial")
    scene.ClearField("initial_tensors")
