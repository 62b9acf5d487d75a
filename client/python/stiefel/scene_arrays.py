"""Fetches the arrays of a session's scene that are too large for a reply."""
from __future__ import annotations

from contextlib import closing
from typing import TYPE_CHECKING

from stiefel import calls
from stiefel import v1 as pb
from stiefel.arrays import Array
from stiefel.assembly import Assembly
from stiefel.checksums import verify_batch
from stiefel.errors import NotFound, StiefelError, Unavailable
from stiefel.recreation import Recreation, pauses
from stiefel.streams import messages

if TYPE_CHECKING:
    from stiefel.client import Client


def scene_arrays(client: Client, handle: Recreation, session_id: str) -> dict[str, Array]:
    """Returns all arrays of the session's resolved scene by their paths in it. They come before the sample at step 0.
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
                    verify_batch(message, b"", b"")
                    assembly.take(message.scene_arrays)
        except StiefelError as broken:
            error: StiefelError = broken
        try:
            calls.pause_or_raise(error, waits, client, deadline)
        except (NotFound, Unavailable) as lost:
            handle.recover(lost, recoveries, deadline)
