"""Steps over one bidirectional stream, where each step costs a message instead of a call."""
from __future__ import annotations

import queue
from typing import Any, Optional

import grpc

from stiefel import v1 as pb
from stiefel._given.mappings import names
from stiefel._given.numbers import step_index
from stiefel._given.typed import Fields
from stiefel._wire.calls import Attempts, Calls
from stiefel._wire.failures import from_status
from stiefel.errors import NotFound, Unavailable
from stiefel.results import State


class Drive:
    """An open stream for many steps of a session, made by `Session.drive`.

    A wrong request raises an exception and does not end the stream. The stream has no deadline; `close`, from any
    thread, ends it.
    """

    def __init__(self, session: Any, fields: Optional[Fields]):
        self._session, self._fields = session, names("fields", fields)
        self._handle: Calls = session._calls
        self._requests: Any = None
        self._replies: Any = None

    def step(self, to: int, *, fields: Optional[Fields] = None, checkpoint: bool = False) -> State:
        """Returns the state at step `to`, or the last good one before it. `fields` stay in force until others are
        named. `checkpoint`: asks for `State.checkpoint`."""
        to, wanted = step_index("to", to), names("fields", fields) or self._fields
        request = pb.DriveRequest(session_id=self._session.id, to=to, fields=wanted,
                                  return_checkpoint=checkpoint or self._handle.wants_checkpoint(to))
        reply = Attempts(self._handle, request, None, endless=True).run(lambda left: self._ask(request))
        state: State = self._session._state(reply, request, wanted, checkpoint)
        self._fields = wanted
        return state

    def _ask(self, request: pb.DriveRequest) -> Any:
        begins = self._replies is None
        if begins:
            method, self._requests = self._handle.connection.stub.Drive, queue.SimpleQueue()
            self._replies = method(iter(self._requests.get, None), metadata=self._handle.metadata(request))
        self._requests.put(request)
        try:
            reply = self._handle.connection.answered(next(self._replies))
            if begins:
                self._handle.check_build(self._replies)
        except StopIteration:
            self.close()
            raise Unavailable("the server ended the drive") from None
        except grpc.RpcError:
            self.close()
            raise
        if reply.HasField("error"):
            error = from_status(reply.error)
            if isinstance(error, (NotFound, Unavailable)):
                self.close()  # the next stream goes to the server where the session is then
            raise error
        return reply.step

    def close(self) -> None:
        """Ends the stream. The next step opens another one."""
        if self._replies is not None:
            self._requests.put(None)
            self._replies.cancel()
            self._replies = None

    def __enter__(self) -> Drive:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def __reduce__(self) -> Any:
        raise TypeError("a drive cannot be pickled, because it is an open stream")

    def __repr__(self) -> str:
        return f"<stiefel.Drive of {self._session.id}, {'idle' if self._replies is None else 'open'}>"
