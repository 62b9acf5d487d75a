"""The connection that a client and its sessions share: the calls of a channel, with deadlines, retries and exceptions.

Pauses between attempts end when the channel connects. While a pause watches the channel, gRPC polls it in a thread that
ends 0.2 s after the pause. An interpreter that ends before that thread never exits, so the exit waits for it, also where
the client is gone already.

A fork of the process closes the channels before and opens them when they are next used, in the parent and in the child:
with an open channel `os.fork` of gRPC 1.51 may never return, and a channel of the parent is of no use to a child.
"""
from __future__ import annotations

import atexit
import math
import os
import re
import sys
import threading
import time
import weakref
from typing import Any, Callable, Optional, Sequence

import grpc

from stiefel import v1 as pb
from stiefel._wire.failures import from_rpc_error
from stiefel._wire.replies import require
from stiefel._wire.retries import Deadline, Pauses
from stiefel.errors import Closed, CorruptReply, DeadlineExceeded, StiefelError, Unavailable, Unimplemented
from stiefel.v1.simulation_pb2_grpc import SimulationServiceStub
from stiefel.version import __version__

WORK_PER_SECOND = 5e9  #: units of work (instructions) that a core does in a second
TOLD_AFTER = 3.0  #: seconds for which a server is away, after which stderr is told
PATIENCE = 5.0  #: seconds that `close` waits for pauses and for gRPC's threads, which end within 0.4 s
Metadata = tuple[tuple[str, str], ...]

_open: "weakref.WeakSet[Connection]" = weakref.WeakSet()
_watched: "weakref.WeakSet[Any]" = weakref.WeakSet()  #: gRPC's states of the channels that were watched
_forking = threading.RLock()  #: held while the process forks, and while a channel is opened


class Connection:
    """The connection of a channel. It is closed at the latest when the process exits. Thread-safe."""

    waits = True  #: whether a server that was reached and went is waited for, until the deadline or for `timeout`

    def __init__(self, open: Callable[[], grpc.Channel], address: str = "", timeout: Optional[float] = None,
                 any_build: bool = False, tls: Optional[bool] = None, reopens: bool = True):
        """`open` returns the channel. `timeout`: seconds of calls that do not get their own. `any_build`: whether sessions
        may go on at a server of another build. `tls`: whether the channel has TLS, if that is known. `reopens`: whether
        `open` returns a new channel each time, so that a fork may close it."""
        self.address, self.timeout, self.any_build = address, timeout, any_build
        self._tls, self._open_channel = tls, open
        self._opened: Optional[_Opened] = None
        self.closed = False
        self._reached = False
        self._told = -math.inf  # when stderr was told that the server is away
        # A channel of `stiefel.aio` has a pause of its own, in which the event loop goes on.
        self._rest = getattr(self.channel, "rest", None)
        self._reopens = reopens and self._rest is None
        self._changed = threading.Condition()
        self._resting: set[threading.Event] = set()
        _open.add(self)

    def _now(self) -> _Opened:
        """The channel, opened if a fork has closed it. Raises `Closed` after `close`."""
        opened = self._opened
        if opened is None:
            with _forking:
                if self.closed:
                    raise self._closed_error()
                opened = self._opened = self._opened or _Opened(self._open_channel())
        return opened

    @property
    def channel(self) -> grpc.Channel:
        return self._now().channel

    @property
    def stub(self) -> SimulationServiceStub:
        """The gRPC stub of the service. Raises `Closed` after `close`."""
        return self._now().stub

    def deadline(self, timeout: Optional[float]) -> Deadline:
        return Deadline(self.timeout if timeout is None else timeout)

    def call(self, method: str, request: Any, timeout: Optional[float] = None, metadata: Metadata = (),
             waits: bool = True) -> Any:
        """Makes a unary call by name."""
        return self.repeat(lambda left: getattr(self.stub, method)(request, timeout=left, metadata=metadata),
                           self.deadline(timeout), waits)

    def systems(self) -> Any:
        """Returns the systems of the server's catalogue."""
        return self.call("Describe", pb.DescribeRequest()).systems

    def call_all(self, method: str, request: Any, timeout: Optional[float] = None) -> Sequence[Any]:
        """Makes a call with a stream of replies and returns all of them."""
        replies: Sequence[Any] = self.repeat(lambda left: tuple(getattr(self.stub, method)(request, timeout=left)),
                                             self.deadline(timeout))
        require(len(replies) > 0, f"{method} has no reply")
        return replies

    def repeat(self, attempt: Callable[[Optional[float]], Any], deadline: Deadline, waits: bool = True) -> Any:
        """Makes attempts of one call until one succeeds. `attempt` gets the seconds that are left. `waits`: whether a
        server that went is waited for."""
        pauses = Pauses()
        while True:
            try:
                reply = attempt(deadline.left())
            except (grpc.RpcError, ValueError) as failure:
                error = self.error(failure)
            else:
                if reply is None:
                    raise CorruptReply("the server ended the call without a reply")
                self._reached = True
                return reply
            self.pause(error, pauses, deadline, waits=waits)

    def pause(self, error: StiefelError, pauses: Pauses, deadline: Deadline, late: bool = False, waits: bool = True) -> None:
        """Waits before the next attempt, or raises `error` if there is no further attempt. If that is because the
        deadline comes first and `late` is set, raises DeadlineExceeded instead. `waits`: as of `repeat`."""
        patience = (deadline.timeout or self.timeout or math.inf) if waits and self.waits and self._reached else 0.0
        wait = pauses.after(error, patience)
        if wait is None:
            raise deadline.explain(error) from None
        if deadline.comes_within(wait):
            if late:
                raise DeadlineExceeded(f"no time is left of {deadline.timeout:g} s: {error.message}") from error
            raise error from None
        if pauses.away > TOLD_AFTER and pauses.missed > self._told:
            self._told = pauses.missed + pauses.away
            left = deadline.left()
            left = patience - pauses.away if left is None else left
            print(f"stiefel: {error.message}; waits for up to {left:.3g} s more", file=sys.stderr)
        self.rest(wait)

    def error(self, failure: Exception) -> StiefelError:
        """Returns this package's exception for one of gRPC's."""
        if self.closed:  # gRPC reports a closed channel with ValueError or CANCELLED
            return self._closed_error()
        if _OF_CLOSED.search(str(failure) if isinstance(failure, ValueError) else getattr(failure, "details", str)() or ""):
            return Unavailable("the process forked, which closed the channel")
        if not isinstance(failure, grpc.RpcError):
            raise failure
        error = from_rpc_error(failure, self._tls, self.address)
        if isinstance(error, DeadlineExceeded):
            error._takes = _takes(failure)
        if isinstance(error, Unimplemented) and not error.reason:  # gRPC's own error names neither call nor version
            said = f" ({error.message})" if error.message else ""
            return Unimplemented(f"the server of {self.address} does not have this call{said}: it needs stiefel-server "
                                 f"{__version__}, the version of this client, or a later one")
        return error

    def _closed_error(self) -> Closed:
        return Closed(f"the client of {self.address} is closed")

    def rest(self, seconds: float) -> None:
        """Waits for `seconds`, or until a disconnected channel has connected, or until `close`. It does not simply
        sleep, because gRPC connects only while the channel is watched or a call runs."""
        over = threading.Event()
        seen: list[grpc.ChannelConnectivity] = []

        def watch(state: grpc.ChannelConnectivity) -> None:
            if state is grpc.ChannelConnectivity.READY and seen:
                over.set()
            seen.append(state)

        if self._rest is not None:
            self._rest(seconds)
            return
        opened = self._opened
        with self._changed:
            if opened is None or opened is not self._opened:
                return
            self._resting.add(over)
            if opened.state is not None:
                _watched.add(opened.state)
        opened.channel.subscribe(watch, try_to_connect=True)
        over.wait(seconds)
        opened.channel.unsubscribe(watch)
        with self._changed:
            self._resting.discard(over)
            self._changed.notify_all()

    def sleep(self, seconds: float) -> None:
        """Waits for `seconds`."""
        (self._rest or threading.Event().wait)(seconds)

    def close(self) -> None:
        """Ends every `rest` and every call, and closes the channel."""
        self.closed = True
        self._close_channel()

    def before_fork(self) -> None:
        """Closes the channel, if it can be opened again."""
        if self._reopens:
            self._close_channel()

    def after_fork(self) -> None:
        """In the child: another thread of the parent may have held the lock. A channel that is open is the parent's."""
        self._changed, self._resting = threading.Condition(), set()
        if self._opened is not None:
            _open.discard(self)

    def _close_channel(self) -> None:
        """Closes the channel when gRPC's thread that watches it has ended: on a closed channel that thread would print a
        ValueError to stderr."""
        with _forking:
            opened, self._opened = self._opened, None
        with self._changed:
            for over in self._resting:
                over.set()
            self._changed.wait_for(lambda: not self._resting, PATIENCE)
        if opened is not None:
            _wait_until(lambda: not _is_watched(opened.state))
            opened.channel.close()


class _Opened:
    """A channel while it is open."""

    def __init__(self, channel: grpc.Channel):
        self.channel = channel
        self.stub = SimulationServiceStub(channel)  # type: ignore[no-untyped-call]
        # Only this private attribute of gRPC tells whether the thread runs; without it there is no such thread.
        self.state = getattr(channel, "_connectivity_state", None)


#: What gRPC says of calls on a channel that was closed before or meanwhile.
_OF_CLOSED = re.compile("(?i)closed channel|channel closed|channel is closed")


def _takes(failure: Any) -> str:
    """How long a failed call takes, as its server told at the beginning; empty if it told nothing."""
    metadata = failure.initial_metadata() if hasattr(failure, "initial_metadata") else None
    told = {key: value for key, value in metadata or ()}
    if "stiefel-work" not in told:
        return ""
    work, bound = float(told["stiefel-work"]), "at most" if "stiefel-work-bound" in told else "about"
    return f"; it takes {bound} {work / WORK_PER_SECOND:.2g} s of one core ({work:.1e} instructions)"


def _is_watched(state: Any) -> bool:
    """Returns whether a thread of this process polls the channel."""
    return state is not None and state in _watched and state.polling


def _wait_until(condition: Callable[[], bool]) -> None:
    end, pause = time.monotonic() + PATIENCE, threading.Event()
    while not condition() and time.monotonic() < end:
        pause.wait(0.005)


def close_all() -> None:
    """Closes every connection of this process."""
    for connection in list(_open):
        connection.close()
    _wait_until(lambda: not any(map(_is_watched, list(_watched))))


def _before_fork() -> None:
    _forking.acquire()
    for connection in list(_open):
        connection.before_fork()


def _forked() -> None:
    """In the child: gRPC's threads are the parent's."""
    _watched.clear()
    for connection in list(_open):
        connection.after_fork()
    _forking.release()


atexit.register(close_all)
if hasattr(os, "register_at_fork"):
    os.register_at_fork(before=_before_fork, after_in_parent=_forking.release, after_in_child=_forked)
