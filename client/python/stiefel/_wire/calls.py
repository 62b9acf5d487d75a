"""The calls of a client and of its sessions, with deadlines, attempts and exceptions.

Every call is idempotent, so it is made again while its server is away, after a refusal that says when to come back, and after
the loss of its session. gRPC's own retry policy keeps to the delay of a refusal, but it makes five attempts at most and none
after the first message of a stream, and it hides the checkpoint that a server that stops sends with its error.
"""
from __future__ import annotations

import random
import re
import sys
import time
from typing import Any, Callable, Generator, Optional, TypeVar

import grpc

from stiefel import v1 as pb
from stiefel._given.numbers import timeout as checked
from stiefel.errors import BuildChanged, DeadlineExceeded, NotFound, StiefelError, Unavailable

ATTEMPTS = 6  #: at a server that was never reached, or has too much at once
TOLD_AFTER = 3.0  #: seconds of pauses, after which stderr is told
WORK_PER_SECOND = WORK_BETWEEN_CHECKPOINTS = 5e9  #: units of work (instructions) that a core does in a second
SHARED_WORK = 5e5  #: the least work of a step that a server may divide among its cores
T = TypeVar("T")
_ROUTABLE = re.compile(r"[A-Za-z0-9._-]{1,128}")


class Calls:
    """Makes calls over a connection: those of one session handle, or of no session. They share the build with which replies are
    compared. A handle that created its session also keeps the scene and the last checkpoint, so that it creates the session again
    when its server is lost, at any server. Thread-safe."""

    def __init__(self, connection: Any, message: pb.Session = pb.Session(), scene: Optional[pb.Scene] = None, checkpoint: bytes = b""):
        """`message`: the description that the handle got first, an empty one for no session. `scene`: creates the session again;
        None for a handle that did not create the session. `checkpoint`: the one with which the session was created."""
        self.connection, self._scene = connection, scene
        self._id, self._numerics, self._step_work = message.session_id, message.numerics_id, message.step_price.work
        # The step of the checkpoint with which the session was created is among the cached steps.
        self._checkpoint = max(message.cached_steps, default=0) if checkpoint else 0, checkpoint
        self._lost = self._ended = False
        self.told = 0  #: the step that the last message of a stream told

    def call(self, method: str, request: Any, timeout: Optional[float] = None, waits: bool = True) -> Any:
        """Makes a unary call by name. `waits`: whether a server that went is waited for."""
        return Attempts(self, request, timeout, waits).run(lambda left: self._send(method, request, left))

    def call_all(self, method: str, request: Any, timeout: Optional[float] = None,
                 seen: Callable[[Any], Any] = lambda reply: None) -> list[Any]:
        """Makes a call with a stream of replies and returns all of them. `seen` gets each when it arrives."""
        return Attempts(self, request, timeout).run(
            lambda left: [(reply, seen(reply))[0] for reply in self.messages(method, request, left)])

    def messages(self, method: str, request: Any, timeout: Optional[float]) -> Generator[Any, None, None]:
        """Makes a call with a stream of replies once, and cancels it when the iteration is left. Raises what gRPC raises, and
        BuildChanged."""
        stream = getattr(self.connection.stub, method)(request, timeout=timeout, metadata=self.metadata(request))
        try:
            for count, message in enumerate(stream):
                if not count:
                    self.check_build(stream)
                yield self.connection.answered(message)
        finally:
            stream.cancel()

    def _send(self, method: str, request: Any, timeout: Optional[float]) -> Any:
        """Makes a unary call once, as `messages` does."""
        reply, call = getattr(self.connection.stub, method).with_call(request, timeout=timeout, metadata=self.metadata(request))
        self.check_build(call)
        return self.connection.answered(reply)

    def metadata(self, request: Any) -> tuple[tuple[str, str], ...]:
        """Returns the metadata of a call: the session by whose id a proxy finds its server, and the token."""
        id = getattr(request, "from_session_id", "") or getattr(request, "session_id", "")
        return (*((("stiefel-session", id),) if _ROUTABLE.fullmatch(id) else ()), *self.connection.bearer)

    def prepare(self, timeout: Optional[float]) -> None:
        """Creates the session again before an attempt if it was lost. Raises NotFound if this handle has deleted its session."""
        if self._ended:
            raise NotFound(f"session_id: {self._id}: this session was deleted", reason="SESSION_DELETED",
                           metadata={"session_id": self._id})
        if self._lost:
            self._create(timeout)

    def _create(self, timeout: Optional[float]) -> None:
        request = pb.CreateSessionRequest(session_id=self._id, scene=self._scene, checkpoint=self._checkpoint[1], recreate=True)
        try:
            self._send("CreateSession", request, timeout)
        except grpc.RpcError as failure:
            error = self.error(failure)
            if error.reason != "CHECKPOINT_OF_OTHER_NUMERICS":
                raise error from None
            if not self.connection.any_build:
                raise BuildChanged(self._id, self._numerics, error.metadata.get("server_numerics_id", "")) from error
            self._checkpoint = 0, b""
            self._create(timeout)
        self._lost = False

    def is_lost(self, error: StiefelError) -> bool:
        """Returns whether `error` means that the session is lost and that this handle creates it again for the next call."""
        lost = error.reason == "SESSION_NOT_FOUND" and error.metadata.get("session_id") == self._id and self._scene is not None
        self._lost |= lost
        return lost

    def end(self) -> None:
        """Call this before deleting the session: the handle never creates it again, and later calls raise NotFound."""
        self._scene, self._ended = None, True

    def error(self, failure: Exception) -> StiefelError:
        """Returns this package's exception, also for one of gRPC's, and keeps the checkpoint that a server that stops sends with it.
        Raises BuildChanged if this handle could create the session at that server, which is of another build."""
        if self._scene is not None and isinstance(failure, grpc.RpcError):
            self.check_build(failure)
        error: StiefelError = failure if isinstance(failure, StiefelError) else self.connection.plain(failure)
        self.keep(*error._checkpoint)
        return error

    def takes(self, request: Any) -> str:
        """Returns how long a call takes, if that is known: the end of a sentence."""
        work = self._step_work * getattr(request, "to", 0) if self._step_work else 0
        return f"; it takes about {work / WORK_PER_SECOND:.2g} s of one core ({work:.1e} instructions)" if work > 0 else ""

    def check_build(self, call: Any) -> None:
        """Raises BuildChanged if the server that answered a call computes other bits than the one where the caller began."""
        if self._numerics and not self.connection.any_build:
            for key, value in call.initial_metadata() or ():
                if key == "stiefel-numerics-id" and value != self._numerics:
                    raise BuildChanged(self._id, self._numerics, value)

    def keep(self, step: int, checkpoint: bytes) -> None:
        """Keeps the checkpoint of the state at `step`, if it is one, with which the session is created again if necessary."""
        if checkpoint:
            self._checkpoint = step, checkpoint

    def checkpoint_every(self) -> int:
        """Returns how many steps of a stream lie between two checkpoints: about a second of one core's work, or eight where
        cores may share a step, because one core alone writes a checkpoint. 0 for none."""
        if self._scene is None or self._step_work <= 0:
            return 0
        work = WORK_BETWEEN_CHECKPOINTS * (8 if self._step_work >= SHARED_WORK else 1)
        return max(1, round(min(work / self._step_work, 2.0**53)))

    def wants_checkpoint(self, to: int) -> bool:
        """Returns whether neither step 0 nor the kept checkpoint lies within the `checkpoint_every()` steps before `to`,
        so that a checkpoint there is worth its bytes."""
        every = self.checkpoint_every()
        return every > 0 and not any(0 <= to - step < every for step in (0, self._checkpoint[0]))


class Attempts:
    """The attempts of one call and the pauses between them, in seconds. While the server is away, or has lost the session:
    0, 0.05, 0.15, 0.35, 0.75, 0.75, ..., six attempts at a server that was never reached, and until the deadline at one that
    was. After a refusal with a delay, until the deadline: that delay and a random time of up to 0.01, 0.02, 0.04 ... 1 s, so
    that callers refused together do not come back together."""

    def __init__(self, calls: Calls, request: Any, timeout: Any, waits: bool = True, endless: bool = False):
        """`timeout`: seconds, a timedelta or a quantity of time for all attempts. If it is None, that of the connection applies,
        except with `endless`, where it is for one time without an answer. `waits`: whether a server that was reached and went
        is waited for. Raises InvalidArgument for another timeout."""
        self._calls, self._request, self._connection = calls, request, calls.connection
        self._waits = waits and self._connection.waits
        self._own = checked(timeout)
        self.timeout = self._connection.timeout if self._own is None and not endless else self._own
        self._end: Optional[float] = None
        self.renew()

    def renew(self) -> None:
        """Begins to count anew, because the call made progress. A timeout of the connection begins anew too."""
        self._failures, self._told, self._since = 0, False, 0.0
        if self.timeout is not None and (self._own is None or self._end is None):
            self._end = time.monotonic() + self.timeout

    def left(self) -> Optional[float]:
        """Returns the seconds that are left, at least 0; None for no end."""
        return None if self._end is None else max(self._end - time.monotonic(), 0.0)

    def run(self, attempt: Callable[[Optional[float]], T]) -> T:
        """Returns what `attempt` returns, which gets the seconds that are left."""
        while True:
            left = self.left()
            try:
                self._calls.prepare(left)
                return attempt(left)
            except (StiefelError, grpc.RpcError, ValueError) as failure:
                self.again(failure)

    def again(self, failure: Exception) -> None:
        """Waits for the next attempt. Raises the exception for `failure` if there is none, or if the deadline comes first."""
        error = self._calls.error(failure)
        wait, left = self._pause(error), self.left()
        if wait is None or left is not None and left < wait:
            if isinstance(error, DeadlineExceeded) and self.timeout is not None:
                error._say(f"{error.message} of {self.timeout:.3g} s{self._calls.takes(self._request)}")
            raise error from None
        self._connection.rest(wait, isinstance(error, Unavailable))

    def _pause(self, error: StiefelError) -> Optional[float]:
        """Returns the seconds before the next attempt; None if there is no further attempt."""
        if isinstance(error, DeadlineExceeded):
            return 0.0 if self.left() else None  # of a stream that began before the last progress
        away, delay, now = isinstance(error, Unavailable) or self._calls.is_lost(error), error.retry_delay, time.monotonic()
        if not away and not error._may_pass and delay is None:
            return None
        self._since = self._since if self._failures else now
        patient = delay is not None or away and self._waits and self._connection.reached
        patience = self._connection.timeout if self.timeout is None else self.timeout
        if self._failures >= ATTEMPTS - 1 and not (patient and (patience is None or now - self._since < patience)):
            return None
        if now - self._since > TOLD_AFTER and not self._told:
            self._told = True
            more = "" if patience is None else f" for up to {patience + self._since - now:.3g} s more"
            print(f"stiefel: {error.message}; waits{more}", file=sys.stderr)
        self._failures += 1
        if delay is None:
            return float(0.05 * (2 ** min(self._failures - 1, ATTEMPTS - 2) - 1))
        return max(delay, 0.0) + random.uniform(0, min(0.01 * 2 ** (self._failures - 1), 1.0))
