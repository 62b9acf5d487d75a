"""The connection of a channel, which a client and its sessions share.

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
from typing import Any, Callable, Optional

import grpc

from stiefel import v1 as pb
from stiefel._wire.arrays import require
from stiefel._wire.calls import Calls
from stiefel._wire.failures import from_rpc_error
from stiefel.errors import Closed, StiefelError, Unavailable
from stiefel.v1.simulation_pb2_grpc import SimulationServiceStub
from stiefel.version import __version__

_open: "weakref.WeakSet[Connection]" = weakref.WeakSet()
_forking = threading.RLock()  #: held while the process forks, and while a channel is opened
_OF_CLOSED = re.compile("(?i)closed channel|channel closed|channel is closed")  # what gRPC says of one, closed before or meanwhile


class Connection(Calls):
    """The connection of a channel. It is closed at the latest when the process exits. Thread-safe."""

    waits = True  #: whether a server that was reached and went is waited for, until the deadline or for `timeout`

    def __init__(self, open: Callable[[], grpc.Channel], address: str = "", timeout: Optional[float] = None,
                 any_build: bool = False, tls: Optional[bool] = None, bearer: tuple[tuple[str, str], ...] = (), reopens: bool = True):
        """`open` returns the channel. `timeout`: seconds of calls that do not get their own. `any_build`: whether sessions
        may go on at a server of another build. `tls`: whether the channel has TLS, if that is known. `bearer`: the metadata with
        the token. `reopens`: whether `open` returns a new channel each time, so that a fork may close it."""
        super().__init__(self)
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
        with _forking:
            if self.closed:
                raise self._closed_error()
            if self._opened is None:
                channel = self._open_channel()
                self._opened = channel, SimulationServiceStub(channel)  # type: ignore[no-untyped-call]
            return self._opened

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
        require(reply is not None, "its bytes are not a message of this call")  # for which grpc.aio returns None
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
            return self._rest(seconds)
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
    for connection in [one for one in _open if one.reopens]:
        connection.close_channel()


def _forked() -> None:
    """In the child: a channel that is still open is the parent's."""
    _open.difference_update([connection for connection in _open if not connection.reopens])
    _forking.release()


atexit.register(close_all)
if hasattr(os, "register_at_fork"):
    os.register_at_fork(before=_before_fork, after_in_parent=_forking.release, after_in_child=_forked)
