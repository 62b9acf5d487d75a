"""Steps over one bidirectional stream, where each step costs a message instead of a call."""
from __future__ import annotations

import queue
from typing import TYPE_CHECKING, Any, Optional

import grpc

from stiefel import calls
from stiefel import v1 as pb
from stiefel.arrays import State
from stiefel.errors import InvalidArgument, NotFound, ResourceExhausted, Unavailable, from_status
from stiefel.given.numbers import step_index
from stiefel.mappings import Names, names
from stiefel.recreation import pauses
from stiefel.replies import complete

if TYPE_CHECKING:
    from stiefel.session import Session


TOO_LARGE = "REPLY_TOO_LARGE"  # the reason of the error after which a state is fetched over Stream instead


class Drive:
    """An open stream for many steps of a session, made by `Session.drive`.

    A wrong request raises an exception and does not end the stream. The stream has no deadline; `close`, from any
    thread, ends it.
    """

    def __init__(self, session: Session, fields: Optional[Names]):
        self._session = session
        self._fields = names("fields", fields)
        self._requests: Any = None
        self._replies: Any = None

    def step(self, to: int, fields: Optional[Names] = None, checkpoint: bool = False) -> State:
        """Returns the state at step `to`, or the last good one before it. `fields` stay in force until others are
        named. `checkpoint`: asks for `State.checkpoint`."""
        to, wanted = step_index("to", to), names("fields", fields) or self._fields
        recreation = self._session._recreation
        request = pb.DriveRequest(session_id=self._session.id, to=to, fields=wanted,
                                  return_checkpoint=checkpoint or recreation.wants_checkpoint(to),
                                  checksum=self._session._client.checksums)
        waits, recoveries = calls.Pauses(), pauses()
        while True:
            try:
                state = self._session._state(self._ask(request), request, wanted, checkpoint)
            except (NotFound, Unavailable) as error:
                try:
                    calls.pause_or_raise(error, waits, self._session._client)
                except (NotFound, Unavailable):
                    recreation.recover(error, recoveries, calls.Deadline(None))
                self.close()  # the next stream goes to the server where the session is now
            except ResourceExhausted as error:
                calls.pause_or_raise(error, waits, self._session._client)
            except InvalidArgument as error:
                if error.reason != TOO_LARGE:
                    raise
                self._fields = wanted
                return self._session.step_in_parts(to, wanted, checkpoint)
            else:
                self._fields = wanted
                return state

    def _ask(self, request: pb.DriveRequest) -> pb.StepResponse:
        recreation, begins = self._session._recreation, self._replies is None
        metadata = recreation.metadata
        if begins:
            method, self._requests = self._session._client.stub.Drive, queue.SimpleQueue()
            self._replies = method(iter(self._requests.get, None), metadata=metadata)
        self._requests.put(request)
        try:
            reply = next(self._replies)
        except grpc.RpcError as failure:
            self.close()
            recreation.check_failure(failure)
            raise self._session._client.error(failure) from None
        except StopIteration:
            self.close()
            raise Unavailable("the server ended the drive") from None
        if begins:
            recreation.check_build(self._replies)
        if reply.HasField("error"):
            raise from_status(reply.error)
        answer: pb.StepResponse = complete(reply, "step").step
        return answer

    def close(self) -> None:
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
