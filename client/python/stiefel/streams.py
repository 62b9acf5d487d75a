"""What the readers of all streams share: how streams end, and checkpoints that come in parts."""
from __future__ import annotations

from typing import TYPE_CHECKING, Any, Iterator

import grpc

from stiefel import v1 as pb
from stiefel.errors import CorruptReply, Internal
from stiefel.recreation import Recreation

if TYPE_CHECKING:
    from stiefel.client import Client


def messages(client: Client, recreation: Recreation, stream: Any) -> Iterator[Any]:
    """Yields the messages of a stream, and cancels the stream when the iteration is left. Raises this package's
    exception if the stream breaks, Internal if it ends before the iteration is left, and BuildChanged."""
    answered = False
    try:
        for message in stream:
            if not answered:
                recreation.check_build(stream)
                answered = True
            yield message
    except grpc.RpcError as failure:
        recreation.check_failure(failure)
        raise client.error(failure) from None
    finally:
        stream.cancel()
    raise Internal("the stream ended without saying how")


class CheckpointParts:
    """Joins the parts of a checkpoint, which come in order."""

    def __init__(self) -> None:
        self._parts: list[bytes] = []

    def take(self, part: pb.CheckpointPart) -> bytes:
        """Returns the whole checkpoint when `part` is its last part, else nothing. Raises CorruptReply if the part does
        not continue the part before it."""
        if part.offset == 0:
            self._parts = []
        begun = sum(map(len, self._parts))
        if part.offset != begun:
            raise CorruptReply(f"a part of the checkpoint of step {part.step} is missing")
        self._parts.append(part.data)
        return b"".join(self._parts) if begun + len(part.data) >= part.size else b""
