"""The arrays of a resolved scene that are too large for a reply, and come for themselves."""
from __future__ import annotations

from contextlib import closing
from typing import Mapping, Optional

from stiefel import v1 as pb
from stiefel._given.shapes import LISTS, owner_of
from stiefel._results.base import Array
from stiefel._wire.arrays import Assembly, decode, matrix, put_block
from stiefel._wire.recreating import Recreation
from stiefel._wire.replies import require
from stiefel._wire.retries import Attempts

_INITIAL = "initial."


def scene_arrays(handle: Recreation, session_id: str) -> dict[str, Array]:
    """Fetches all arrays of the session's resolved scene, by their paths in it."""
    request = pb.StreamRequest(session_id=session_id, scene_arrays=True)

    def attempt(left: Optional[float]) -> dict[str, Array]:
        assembly = Assembly()
        with closing(handle.messages("Stream", request, left)) as arriving:
            for message in arriving:
                if message.steps:  # the sample at step 0, which comes last
                    break
                assembly.take(message.scene_arrays)
        return assembly.finish()
    return Attempts(handle.connection, None, handle).run(attempt)


def put(arrays: Mapping[str, Array], scene: pb.Scene) -> None:
    """Sets arrays of a scene. Their names are paths in the scene: "initial.Q", "inertia", "body.attitude"."""
    for path, array in arrays.items():
        if path.startswith(_INITIAL):
            put_block(scene, path[len(_INITIAL):], array)
            continue
        require(path in LISTS, f"a scene has no array {path}")
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
