"""The connection that a client and its sessions share: the calls of a channel, with deadlines, retries and exceptions.

A fork of the process closes the channels before, and they are opened again when they are next used, in the parent and in
the child: with an open channel `os.fork` of gRPC 1.51 may never return, and a channel of the parent is of no use to a child.
"""
from __future__ import annotations

import atexit
import os
import re
import threading
import time
import weakref
from contextlib import suppress
from typing import Any, Callable, Generator, Optional

import grpc

from stiefel import v1 as pb
from stiefel._wire.failures import from_rpc_error
from stiefel._wire.retries import Attempts
from stiefel.errors import Closed, CorruptReply, StiefelError, Unavailable
from stiefel.v1.simulation_pb2_grpc import SimulationServiceStub
from stiefel.version import __version__

WORK_PER_SECOND = 5e9  #: units of work (instructions) that a core does in a second
Metadata = tuple[tuple[str, str], ...]

_open: "weakref.WeakSet[Connection]" = weakref.WeakSet()
_forking = threading.RLock()  #: held while the process forks, and while a channel is opened
#: What gRPC says of calls on a channel that was closed before or meanwhile.
_OF_CLOSED = re.compile("(?i)closed channel|channel closed|channel is closed")


class Calls:
    """Makes calls over a connection: those of no session, or those of one, which `Recreation` makes."""

    connection: Connection

    def metadata(self, timeout: Optional[float]) -> Metadata:
        """Prepares a call and returns its metadata."""
        return ()

    def check_build(self, call: Any) -> None:
        """Raises BuildChanged if the server that answered a call computes other bits than the one where the caller began."""

    def error(self, failure: Exception) -> StiefelError:
        """Returns this package's exception for one of gRPC's."""
        return self.connection.plain(failure)

    def is_lost(self, error: StiefelError) -> bool:
        """Returns whether the next call succeeds because it creates the session again."""
        return False

    def takes(self, request: Any) -> str:
        """Returns how long a call takes, if that is known: the end of a sentence."""
        return ""

    def call(self, method: str, request: Any, timeout: Optional[float] = None, metadata: Metadata = (),
             waits: bool = True) -> Any:
        """Makes a unary call by name. `waits`: whether a server that went is waited for."""
        return Attempts(self, request, timeout, waits).run(
            lambda left: self.send(method, request, left, (*metadata, *self.metadata(left))))

    def call_all(self, method: str, request: Any, timeout: Optional[float] = None,
                 seen: Callable[[Any], None] = lambda reply: None) -> list[Any]:
        """Makes a call with a stream of replies and returns all of them. `seen` gets each when it arrives."""
        def attempt(left: Optional[float]) -> list[Any]:
            replies = []
            for reply in self.messages(method, request, left):
                replies.append(reply)
                seen(reply)
            return replies
        return Attempts(self, request, timeout).run(attempt)

    def send(self, method: str, request: Any, timeout: Optional[float], metadata: Metadata) -> Any:
        """Makes a unary call once. Raises what gRPC raises, and BuildChanged."""
        reply, call = getattr(self.connection.stub, method).with_call(
            request, timeout=timeout, metadata=(*metadata, *self.connection.bearer))
        self.check_build(call)
        return self.connection.answered(reply)

    def messages(self, method: str, request: Any, timeout: Optional[float]) -> Generator[Any, None, None]:
        """Makes a call with a stream of replies once, and cancels it when the iteration is left. Raises as `send` does."""
        stream = getattr(self.connection.stub, method)(
            request, timeout=timeout, metadata=(*self.metadata(timeout), *self.connection.bearer))
        try:
            for count, message in enumerate(stream):
                if not count:
                    self.check_build(stream)
                yield self.connection.answered(message)
        finally:
            stream.cancel()


class Connection(Calls):
    """The connection of a channel. It is closed at the latest when the process exits. Thread-safe."""

    waits = True  #: whether a server that was reached and went is waited for, until the deadline or for `timeout`

    def __init__(self, open: Callable[[], grpc.Channel], address: str = "", timeout: Optional[float] = None,
                 any_build: bool = False, tls: Optional[bool] = None, bearer: Metadata = (), reopens: bool = True):
        """`open` returns the channel. `timeout`: seconds of calls that do not get their own. `any_build`: whether sessions
        may go on at a server of another build. `tls`: whether the channel has TLS, if that is known. `bearer`: the metadata with
        the token. `reopens`: whether `open` returns a new channel each time, so that a fork may close it."""
        self.connection = self
        self.address, self.timeout, self.any_build, self.bearer = address, timeout, any_build, bearer
        self._tls, self._open_channel = tls, open
        self._opened: Optional[tuple[grpc.Channel, SimulationServiceStub]] = None
        self._closing = threading.Event()
        self.reached = False  #: whether the server has answered a call
        # A channel of `stiefel.aio` has a pause of its own, in which the event loop goes on.
        self._rest: Optional[Callable[[float], None]] = getattr(self.channel, "rest", None)
        self.reopens = reopens and self._rest is None
        _open.add(self)

    def _now(self) -> tuple[grpc.Channel, SimulationServiceStub]:
        opened = self._opened
        if opened is None:
            with _forking:
                if self.closed:
                    raise self._closed_error()
                if self._opened is None:
                    channel = self._open_channel()
                    self._opened = channel, SimulationServiceStub(channel)  # type: ignore[no-untyped-call]
                opened = self._opened
        return opened

    @property
    def channel(self) -> grpc.Channel:
        """The channel, opened if a fork has closed it. Raises `Closed` after `close`."""
        return self._now()[0]

    @property
    def stub(self) -> SimulationServiceStub:
        """The gRPC stub of the service. Raises `Closed` after `close`."""
        return self._now()[1]

    @property
    def closed(self) -> bool:
        return self._closing.is_set()

    def systems(self) -> Any:
        """Returns the systems of the server's catalogue."""
        return self.call("Describe", pb.DescribeRequest()).systems

    def answered(self, reply: Any) -> Any:
        """Returns the reply of a call, which shows that there is a server."""
        if reply is None:  # as grpc.aio returns for bytes that are no message
            raise CorruptReply("the reply is missing, or its bytes are not a message of this call")
        self.reached = True
        return reply

    def plain(self, failure: Exception) -> StiefelError:
        """Returns this package's exception for one of gRPC's."""
        if self.closed:  # gRPC reports a closed channel with ValueError or CANCELLED
            return self._closed_error()
        if _OF_CLOSED.search(str(failure) if isinstance(failure, ValueError) else getattr(failure, "details", str)() or ""):
            return Unavailable("the process forked, which closed the channel")
        if not isinstance(failure, grpc.RpcError):
            raise failure
        error = from_rpc_error(failure, self._tls, self.address)
        if error.code is grpc.StatusCode.UNIMPLEMENTED and not error.reason:  # gRPC's own names neither call nor version
            error._say(f"the server of {self.address} does not have this call ({error.message}): it needs stiefel-server "
                       f"{__version__}, the version of this client, or a later one")
        return error

    def _closed_error(self) -> Closed:
        return Closed(f"the client of {self.address} is closed")

    def rest(self, seconds: float, away: bool = False) -> None:
        """Waits for `seconds`, or until `close`. `away`: whether the server is away. gRPC connects only while a call runs, so
        it then makes one that does nothing."""
        if self._rest is not None:
            self._rest(seconds)
            return
        end = time.monotonic() + seconds
        if away:
            with suppress(grpc.RpcError, ValueError, Closed):
                self.channel.unary_unary("/grpc.health.v1.Health/Check")(b"", timeout=seconds, wait_for_ready=True)
        self._closing.wait(max(end - time.monotonic(), 0))

    def close(self) -> None:
        """Ends every `rest` and every call, and closes the channel."""
        self._closing.set()
        self.close_channel()

    def close_channel(self) -> None:
        with _forking:
            opened, self._opened = self._opened, None
        if opened is not None:
            opened[0].close()


def close_all() -> None:
    """Closes every connection of this process."""
    for connection in list(_open):
        connection.close()


def _before_fork() -> None:
    _forking.acquire()
    for connection in list(_open):
        if connection.reopens:
            connection.close_channel()


def _forked() -> None:
    """In the child: a channel that is still open is the parent's."""
    for connection in list(_open):
        if not connection.reopens:
            _open.discard(connection)
    _forking.release()


atexit.register(close_all)
if hasattr(os, "register_at_fork"):
    os.register_at_fork(before=_before_fork, after_in_parent=_forking.release, after_in_child=_forked)
