"""Steps over one bidirectional stream: a reply costs a message and not a call."""
from __future__ import annotations

import queue
from typing import TYPE_CHECKING, Any, Optional

import grpc

from stiefel import calls
from stiefel.arrays import State
from stiefel.errors import Unavailable, make_error
from stiefel.names import Names, names
from stiefel.v1 import simulation_pb2 as pb

if TYPE_CHECKING:
    from stiefel.client import Client


class Drive:
    """Made by `Session.drive`. A request in error raises and does not end the stream.

    The stream has no deadline; `close`, from any thread, ends it.
    """

    def __init__(self, client: Client, session_id: str, fields: Optional[Names]):
        self._client = client
        self._session_id = session_id
        self._fields = names("fields", fields)
        self._requests: Any = None
        self._replies: Any = None

    def step(self, to: int, fields: Optional[Names] = None, checkpoint: bool = False) -> State:
        """As `Session.step`. `fields` hold for the requests after this one too."""
        wanted = names("fields", fields) or self._fields
        request = pb.DriveRequest(session_id=self._session_id, to=to, fields=wanted, checkpoint=checkpoint)
        waits = calls.pauses()
        while True:
            try:
                state = self._ask(request)
            except Unavailable as error:
                self.close()
                calls.pause_or_raise(error, waits)
            else:
                self._fields = wanted
                return state

    def _ask(self, request: pb.DriveRequest) -> State:
        if self._replies is None:
            method, self._requests = self._client.stub.Drive, queue.SimpleQueue()
            self._replies = method(iter(self._requests.get, None))
        self._requests.put(request)
        try:
            reply = next(self._replies)
        except grpc.RpcError as failure:
            self.close()
            raise self._client.error(failure) from None
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

    def __repr__(self) -> str:
        return f"<stiefel.Drive of {self._session_id}, {'idle' if self._replies is None else 'open'}>"
