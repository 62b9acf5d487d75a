"""Steps over one bidirectional stream: a reply costs a message and not a call."""
from __future__ import annotations

import queue
from typing import Any, Callable, Optional, Sequence

import grpc

from stiefel import calls
from stiefel.arrays import State
from stiefel.errors import Unavailable, from_rpc_error, make_error
from stiefel.v1 import simulation_pb2 as pb


class Drive:
    """Made by `Session.drive`. A request in error raises and does not end the stream.

    The stream has no deadline; `close`, from any thread, ends it.
    """

    def __init__(self, method: Callable[..., Any], session_id: str, fields: Optional[Sequence[str]]):
        self._method = method
        self._session_id = session_id
        self._fields = fields
        self._requests: Any = None
        self._replies: Any = None

    def step(self, to: int, fields: Optional[Sequence[str]] = None, checkpoint: bool = False) -> State:
        """As `Session.step`. `fields` hold for the requests after this one too."""
        fields = fields or self._fields
        request = pb.DriveRequest(session_id=self._session_id, to=to, fields=fields, checkpoint=checkpoint)
        waits = calls.pauses()
        while True:
            try:
                state = self._ask(request)
            except Unavailable as error:
                self.close()
                calls.pause_or_raise(error, waits)
            else:
                self._fields = fields
                return state

    def _ask(self, request: pb.DriveRequest) -> State:
        if self._replies is None:
            self._requests = queue.SimpleQueue()
            self._replies = self._method(iter(self._requests.get, None))
        self._requests.put(request)
        try:
            reply = next(self._replies)
        except grpc.RpcError as error:
            self.close()
            raise from_rpc_error(error) from None
        if reply.HasField("error"):
            raise make_error(reply.error.code, reply.error.message, reply.error.details)
        return State.of(reply.step)

    def close(self) -> None:
        if self._replies is not None:
            self._requests.put(None)
            self._replies.cancel()
            self._replies = None

    def __enter__(self) -> Drive:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()
