"""Creates a session again when its server is lost. Only the handle that created the session does so."""
from __future__ import annotations

import re
from typing import Any, Generator, Optional

import grpc

from stiefel import v1 as pb
from stiefel._wire.connection import WORK_PER_SECOND, Connection, Metadata
from stiefel._wire.retries import Attempts
from stiefel.errors import BuildChanged, CorruptReply, NotFound, StiefelError

WORK_BETWEEN_CHECKPOINTS = WORK_PER_SECOND

_SESSION, _NUMERICS = "stiefel-session", "stiefel-numerics-id"
_ROUTABLE = re.compile(r"[A-Za-z0-9._-]{1,128}")


def route(id: str) -> Metadata:
    """Returns the metadata by which a proxy finds the server of a session; none for an invalid id."""
    return ((_SESSION, id),) if _ROUTABLE.fullmatch(id) else ()


class Recreation:
    """What the calls of one session handle share: the id by which proxies route them, and the build with which replies
    are compared. A handle that created its session also keeps the scene and the last checkpoint, so that any server can
    take the session over. Thread-safe.
    """

    def __init__(self, connection: Connection, message: pb.Session, scene: Optional[pb.Scene] = None,
                 checkpoint: bytes = b""):
        """`message`: the description that the handle got first. `scene`: creates the session again; None for a
        handle that did not create the session. `checkpoint`: the one with which the session was created."""
        self.connection = connection
        self._id = message.session_id
        self._numerics = message.numerics_id
        self._step_work = message.step_price.work
        self._scene = scene
        # The step of the checkpoint with which the session was created is among the cached steps.
        self._checkpoint = max(message.cached_steps, default=0) if checkpoint else 0, checkpoint
        self._lost = self._ended = False
        self.reached = 0  #: the step that the last message of a stream told

    def call(self, method: str, request: Any, timeout: Optional[float] = None) -> Any:
        """Makes a unary call by name, and repeats it after the session had to be created again."""
        return Attempts(self.connection, timeout, self).run(lambda left: self._send(method, request, left, self.metadata(left)))

    def metadata(self, timeout: Optional[float]) -> Metadata:
        """Creates the session again if it was lost, and returns the metadata of every call. Raises NotFound if this handle
        has deleted its session."""
        if self._ended:
            raise NotFound(f"session_id: {self._id}: this session was deleted", reason="SESSION_DELETED",
                           metadata={"session_id": self._id})
        if self._lost:
            self._create(timeout)
        return route(self._id)

    def is_lost(self, error: StiefelError) -> bool:
        """Returns whether `error` means that the session is lost and that this handle creates it again for the next call."""
        gone = error.reason == "SESSION_NOT_FOUND" and error.metadata.get("session_id") == self._id
        lost = gone and self._scene is not None
        self._lost |= lost
        return lost

    def end(self) -> None:
        """Call this before deleting the session: the handle never creates it again, and later calls raise NotFound."""
        self._scene, self._ended = None, True

    def failed(self, failure: grpc.RpcError, to: int = 0) -> StiefelError:
        """Returns the exception of a failed call, `to` the last step of it. Raises BuildChanged if this handle could create the session at that server,
        which is of another build."""
        if self._scene is not None:
            self.check_build(failure)
        error, work = self.connection.error(failure), self._step_work * to
        if work > 0:
            error._takes = f"; it takes about {work / WORK_PER_SECOND:.2g} s of one core ({work:.1e} instructions)"
        self.keep_of(error)
        return error

    def check_build(self, call: Any) -> None:
        """Raises BuildChanged if the server that answered a call computes other bits than the one where the handle
        began."""
        if self.connection.any_build or not self._numerics:
            return
        for key, value in call.initial_metadata() or ():
            if key == _NUMERICS and value != self._numerics:
                raise BuildChanged(self._id, self._numerics, value)

    def keep_of(self, error: StiefelError) -> None:
        """Keeps the checkpoint that a server that ends sends with its error."""
        if error._checkpoint[1]:
            self.keep(*error._checkpoint)

    def keep(self, step: int, checkpoint: bytes) -> None:
        """Keeps the checkpoint of the state at `step`, with which the session is created again if necessary."""
        self._checkpoint = step, checkpoint

    def checkpoint_every(self) -> int:
        """Returns how many steps of a stream lie between two checkpoints: about a second of work. 0 for none."""
        if self._scene is None or self._step_work <= 0:
            return 0
        return max(1, round(min(WORK_BETWEEN_CHECKPOINTS / self._step_work, 2.0**53)))

    def wants_checkpoint(self, to: int) -> bool:
        """Returns whether neither step 0 nor the kept checkpoint lies within the `checkpoint_every()` steps before `to`,
        so that a checkpoint there is worth its bytes."""
        every = self.checkpoint_every()
        return every > 0 and not any(0 <= to - step < every for step in (0, self._checkpoint[0]))

    def messages(self, method: str, request: Any, timeout: Optional[float]) -> Generator[Any, None, None]:
        """Yields the messages of a stream, and cancels the stream when the iteration is left. Raises this package's
        exception if the stream breaks, CorruptReply if it ends before the iteration is left, and BuildChanged."""
        metadata, answered = self.metadata(timeout), False
        stream = getattr(self.connection.stub, method)(request, timeout=timeout, metadata=metadata)
        try:
            for message in stream:
                if not answered:
                    self.check_build(stream)
                    answered = self.connection.reached = True
                self.reached = getattr(message, "step", self.reached)
                yield message
        except grpc.RpcError as failure:
            raise self.failed(failure, getattr(request, "to", 0)) from None
        finally:
            stream.cancel()
        raise CorruptReply("the stream ended without saying how the run ended: a part of it is missing")

    def _send(self, method: str, request: Any, timeout: Optional[float], metadata: Metadata) -> Any:
        try:
            reply, call = getattr(self.connection.stub, method).with_call(request, timeout=timeout, metadata=metadata)
        except grpc.RpcError as failure:
            raise self.failed(failure, getattr(request, "to", 0)) from None
        self.check_build(call)
        return self.connection.answered(reply)

    def _create(self, timeout: Optional[float]) -> None:
        scene, checkpoint = self._scene, self._checkpoint[1]
        if scene is None:
            return
        request = pb.CreateSessionRequest(session_id=self._id, scene=scene, checkpoint=checkpoint, recreate=True,
                                          view=pb.SessionView(scene=pb.SCENE_VIEW_NONE))
        try:
            self._send("CreateSession", request, timeout, route(self._id))
        except StiefelError as error:
            if not checkpoint or not refuses_checkpoint(error):
                raise
            if error.reason == "CHECKPOINT_OF_OTHER_NUMERICS" and not self.connection.any_build:
                raise BuildChanged(self._id, self._numerics, error.metadata.get("server_numerics_id", "")) from error
            request.checkpoint = b""
            self.keep(0, b"")
            self._send("CreateSession", request, timeout, route(self._id))
        self._lost = False
        if self._ended:  # the handle was deleted meanwhile, and the deletion may have arrived before the creation
            self.connection.call("DeleteSession", pb.DeleteSessionRequest(session_id=self._id), metadata=route(self._id))


def refuses_checkpoint(error: StiefelError) -> bool:
    """Returns whether the request may succeed without its checkpoint."""
    return error.reason.startswith("CHECKPOINT_") or any(v.field == "checkpoint" for v in error.violations)
