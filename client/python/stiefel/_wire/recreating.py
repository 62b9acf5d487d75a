"""Creates a session again when its server is lost. Only the handle that created the session does so."""
from __future__ import annotations

import re
from typing import Any, Optional

import grpc

from stiefel import v1 as pb
from stiefel._wire.connection import WORK_PER_SECOND, Calls, Connection, Metadata
from stiefel.errors import BuildChanged, NotFound, StiefelError

WORK_BETWEEN_CHECKPOINTS = WORK_PER_SECOND

_SESSION, _NUMERICS = "stiefel-session", "stiefel-numerics-id"
_ROUTABLE = re.compile(r"[A-Za-z0-9._-]{1,128}")


def route(id: str) -> Metadata:
    """Returns the metadata by which a proxy finds the server of a session; none for an invalid id."""
    return ((_SESSION, id),) if _ROUTABLE.fullmatch(id) else ()


class Recreation(Calls):
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
        lost = (self._scene is not None and error.reason == "SESSION_NOT_FOUND"
                and error.metadata.get("session_id") == self._id)
        self._lost |= lost
        return lost

    def end(self) -> None:
        """Call this before deleting the session: the handle never creates it again, and later calls raise NotFound."""
        self._scene, self._ended = None, True

    def error(self, failure: Exception) -> StiefelError:
        """Returns this package's exception, and keeps the checkpoint that a server that stops sends with it. Raises BuildChanged
        if this handle could create the session at that server, which is of another build."""
        if self._scene is not None and isinstance(failure, grpc.RpcError):
            self.check_build(failure)
        return self.kept(self.connection.plain(failure))

    def kept(self, error: StiefelError) -> StiefelError:
        """Keeps the checkpoint of `error`, and returns it."""
        if error._checkpoint[1]:
            self.keep(*error._checkpoint)
        return error

    def takes(self, request: Any) -> str:
        work = self._step_work * getattr(request, "to", 0)
        return f"; it takes about {work / WORK_PER_SECOND:.2g} s of one core ({work:.1e} instructions)" if work > 0 else ""

    def check_build(self, call: Any) -> None:
        if self.connection.any_build or not self._numerics:
            return
        for key, value in call.initial_metadata() or ():
            if key == _NUMERICS and value != self._numerics:
                raise BuildChanged(self._id, self._numerics, value)

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

    def _create(self, timeout: Optional[float]) -> None:
        scene = self._scene
        if scene is None:
            return
        request = pb.CreateSessionRequest(session_id=self._id, scene=scene, checkpoint=self._checkpoint[1], recreate=True)
        try:
            self.send("CreateSession", request, timeout, route(self._id))
        except grpc.RpcError as failure:
            error = self.error(failure)
            if error.reason != "CHECKPOINT_OF_OTHER_NUMERICS":
                raise error from None
            if not self.connection.any_build:
                raise BuildChanged(self._id, self._numerics, error.metadata.get("server_numerics_id", "")) from error
            self.keep(0, b"")
            self._create(timeout)
        self._lost = False
