"""Creates a session again when its server is lost. Only the handle that created the session does so."""
from __future__ import annotations

import re
import threading
from contextlib import contextmanager
from typing import Any, Callable, Generator, Iterator, NamedTuple, Optional

import grpc

from stiefel import v1 as pb
from stiefel._wire.connection import WORK_PER_SECOND, Connection, Metadata
from stiefel._wire.failures import from_rpc_error
from stiefel._wire.retries import Deadline, Pauses
from stiefel.errors import BuildChanged, CorruptReply, DeadlineExceeded, NotFound, StiefelError, Unavailable

WORK_BETWEEN_CHECKPOINTS = WORK_PER_SECOND
STOP = 0.06  #: seconds in which a server ends a call whose time is over
ANSWER = 0.25  #: seconds that a server gets to say where a session stands

#: The most recreations of a session within one call. They are many, because servers may be lost one after the other and
#: each recreation is progress.
RECOVERIES = 54

_SESSION, _NUMERICS = "stiefel-session", "stiefel-numerics-id"
_ROUTABLE = re.compile(r"[A-Za-z0-9._-]{1,128}")


def route(id: str) -> Metadata:
    """Returns the metadata by which a proxy finds the server of a session; none for an invalid id."""
    return ((_SESSION, id),) if _ROUTABLE.fullmatch(id) else ()


def pauses() -> Iterator[float]:
    """Yields the seconds to wait before each recreation: 0.025, 0.05, 0.1, 0.2, 0.4, 0.4, ..., 20.375 s in all."""
    return (0.025 * 2**min(recovery, 4) for recovery in range(RECOVERIES))


class Checkpoint(NamedTuple):
    step: int
    state: bytes  #: empty for step 0, which every server has


START = Checkpoint(0, b"")


class Recreation:
    """What the calls of one session handle share: the id by which proxies route them, and the build with which replies
    are compared. A handle that created its session also keeps the scene and two checkpoints, so that any server can
    take the session over: the last checkpoint, and the earliest one for calls that go back. Thread-safe.
    """

    def __init__(self, connection: Connection, message: pb.Session, scene: Optional[Callable[[], pb.Scene]] = None,
                 checkpoint: bytes = b""):
        """`message`: the description that the handle got first. `scene`: returns the scene that creates the session
        again; None for a handle that did not create it. `checkpoint`: the one with which the session was created."""
        self.connection = connection
        self._id = message.session_id
        self._numerics = message.numerics_id
        self._step_work = message.step_price.work
        self._scene = scene
        self._lock = threading.Lock()
        # The step of the checkpoint with which the session was created is among the cached steps.
        self._earliest = self._last = Checkpoint(max(message.cached_steps, default=0), checkpoint) if checkpoint else START
        self._ended = False
        self.reached = 0  #: the step that the last message of a stream told

    @property
    def metadata(self) -> Metadata:
        """The metadata of every call. Raises NotFound if this handle has deleted its session."""
        if self._ended:
            raise NotFound(f"session_id: {self._id}: this session was deleted", reason="SESSION_DELETED",
                           metadata={"session_id": self._id})
        return route(self._id)

    def call(self, method: str, request: Any, timeout: Optional[float] = None) -> Any:
        """Makes a unary call by name, and repeats it after the session had to be created again."""
        deadline, waits = self.connection.deadline(timeout), pauses()
        while True:
            try:
                return self._send(method, request, deadline)
            except NotFound as error:
                self.recover(error, waits, deadline)

    def recover(self, error: StiefelError, waits: Iterator[float], deadline: Deadline) -> None:
        """Pauses and creates the session again. Raises `error` if this handle must not create it, if `waits` are used
        up or if the deadline comes first, and BuildChanged if a server of another build answers.

        There is no pause after the creation: when servers end one after the other, the session could be lost again in
        that pause."""
        pause_after_loss(error, self.is_gone(error), waits, deadline, self.connection)
        self._create(deadline)

    @contextmanager
    def explains(self, to: int) -> Iterator[None]:
        """Adds to a DeadlineExceeded where the session stands."""
        try:
            yield
        except DeadlineExceeded as late:
            late._say(f"{late.message}: step {to} was not reached{self._standing()}")
            raise

    def _standing(self) -> str:
        self.connection.sleep(STOP)
        try:
            request = pb.GetSessionRequest(session_id=self._id, view=pb.SessionView(scene=pb.SCENE_VIEW_NONE))
            session = self.connection.stub.GetSession(request, timeout=ANSWER, metadata=self.metadata).session
        except (StiefelError, grpc.RpcError, ValueError):
            return ", and the server does not answer"
        return f"; the session stands at step {session.cursor}, from where the same call goes on"

    def is_gone(self, error: StiefelError) -> bool:
        """Returns whether `error` means that the session or its server is gone and this handle may create it again."""
        return self._scene is not None and is_loss(error, self._id)

    def end(self) -> None:
        """Call this before deleting the session: the handle never creates it again, and later calls raise NotFound."""
        self._scene, self._ended = None, True

    def check_build(self, call: Any) -> None:
        """Raises BuildChanged if the server that answered a call computes other bits than the one where the handle
        began."""
        if self.connection.any_build or not self._numerics:
            return
        for key, value in call.initial_metadata() or ():
            if key == _NUMERICS and value != self._numerics:
                raise BuildChanged(self._id, self._numerics, value)

    def check_failure(self, call: Any) -> None:
        """Does `check_build` for a failed call, but only if this handle could create the session at that server, and
        `keep_of`."""
        if self._scene is not None:
            self.check_build(call)
            self.keep_of(from_rpc_error(call))

    def keep_of(self, error: StiefelError) -> None:
        """Keeps the checkpoint that a server that ends sends with its error."""
        step, checkpoint = error._checkpoint
        if checkpoint:
            self.keep(step, checkpoint)

    def keep(self, step: int, checkpoint: bytes) -> None:
        """Keeps the checkpoint of the state at `step`, with which the session is created again if necessary."""
        with self._lock:
            self._last = Checkpoint(step, checkpoint)
            if not self._earliest.state or step < self._earliest.step:
                self._earliest = self._last

    @property
    def has_checkpoint(self) -> bool:
        return bool(self._last.state)

    def checkpoint_every(self) -> int:
        """Returns how many steps of a stream lie between two checkpoints: about a second of work. 0 for none."""
        if self._scene is None or self._step_work <= 0:
            return 0
        return max(1, round(min(WORK_BETWEEN_CHECKPOINTS / self._step_work, 2.0**53)))

    def wants_checkpoint(self, to: int) -> bool:
        """Returns whether neither step 0 nor a kept checkpoint lies within the `checkpoint_every()` steps before `to`,
        so that a checkpoint there is worth its bytes."""
        every = self.checkpoint_every()
        with self._lock:
            steps = 0, self._earliest.step, self._last.step
        return every > 0 and not any(0 <= to - step < every for step in steps)

    def messages(self, method: str, request: Any, timeout: Optional[float]) -> Generator[Any, None, None]:
        """Yields the messages of a stream, and cancels the stream when the iteration is left. Raises this package's
        exception if the stream breaks, CorruptReply if it ends before the iteration is left, and BuildChanged."""
        stream, answered = getattr(self.connection.stub, method)(request, timeout=timeout, metadata=self.metadata), False
        try:
            for message in stream:
                if not answered:
                    self.check_build(stream)
                    answered = True
                self.reached = getattr(message, "step", self.reached)
                yield message
        except grpc.RpcError as failure:
            self.check_failure(failure)
            raise self.connection.error(failure) from None
        finally:
            stream.cancel()
        raise CorruptReply("the stream ended without saying how the run ended: a part of it is missing")

    def _attempt(self, method: str, request: Any, timeout: Optional[float]) -> Any:
        try:
            reply, call = getattr(self.connection.stub, method).with_call(request, timeout=timeout, metadata=self.metadata)
        except grpc.RpcError as failure:
            self.check_failure(failure)
            raise
        self.check_build(call)
        return reply

    def _create(self, deadline: Deadline) -> None:
        scene = self._scene
        if scene is None:
            return
        with self._lock:
            checkpoints = dict.fromkeys((self._earliest, self._last))  # without duplicates
        request = pb.CreateSessionRequest(session_id=self._id, scene=scene(), recreate=True,
                                          view=pb.SessionView(scene=pb.SCENE_VIEW_NONE))
        try:
            for checkpoint in checkpoints:
                request.checkpoint = checkpoint.state
                self._send("CreateSession", request, deadline)
        except StiefelError as error:
            if not request.checkpoint or not refuses_checkpoint(error):
                raise
            if error.reason == "CHECKPOINT_OF_OTHER_NUMERICS" and not self.connection.any_build:
                raise BuildChanged(self._id, self._numerics, error.metadata.get("server_numerics_id", "")) from error
            with self._lock:
                self._earliest = self._last = START
            request.checkpoint = b""
            self._send("CreateSession", request, deadline)
        if self._ended:  # the handle was deleted meanwhile, and the deletion may have arrived before the creation
            self.connection.call("DeleteSession", pb.DeleteSessionRequest(session_id=self._id), metadata=route(self._id))

    def _send(self, method: str, request: Any, deadline: Deadline) -> Any:
        return self.connection.repeat(lambda left: self._attempt(method, request, left), deadline)


class Attempts:
    """The attempts of one call of a handle, after each of which the server may have been lost with the session."""

    def __init__(self, handle: Recreation, deadline: Deadline, late: bool = True):
        """`late`: whether a deadline that comes before the next attempt is the error."""
        self._handle = handle
        self._late = late
        self.deadline = deadline
        self.renew()

    def renew(self) -> None:
        """Begins to count anew, because the call made progress."""
        self._waits, self._recoveries = Pauses(), pauses()

    def again(self, error: StiefelError) -> None:
        """Waits for the next attempt, and creates the session again if need be. Raises an exception if there is none."""
        try:
            self._handle.connection.pause(error, self._waits, self.deadline, self._late)
        except NotFound as lost:
            self.recover(lost)

    def recover(self, lost: StiefelError) -> None:
        self._handle.recover(lost, self._recoveries, self.deadline)


def is_loss(error: StiefelError, id: str) -> bool:
    """Returns whether `error` means that the session or its server is gone."""
    return isinstance(error, Unavailable) or (
        error.reason == "SESSION_NOT_FOUND" and error.metadata.get("session_id") == id)


def pause_after_loss(error: StiefelError, may_go_on: bool, waits: Iterator[float], deadline: Deadline,
                     connection: Connection) -> None:
    """Waits for the next of `waits`. Raises `error` if they are used up, if the deadline comes first, or without
    `may_go_on`."""
    wait = next(waits, None) if may_go_on else None
    if wait is None or deadline.comes_within(wait):
        raise error from None
    connection.rest(wait)


def refuses_checkpoint(error: StiefelError) -> bool:
    """Returns whether the request may succeed without its checkpoint."""
    return error.reason.startswith("CHECKPOINT_") or any(v.field == "checkpoint" for v in error.violations)
