"""The connection that a client and its sessions share: the calls of a channel, with deadlines, retries and exceptions.

Pauses between attempts end when the channel connects. While a pause watches the channel, gRPC polls it in a thread that
ends 0.2 s after the pause. An interpreter that ends before that thread never exits, so the exit waits for it, also where
the client is gone already.
"""
from __future__ import annotations

import atexit
import os
import threading
import time
import weakref
from typing import Any, Callable, Optional, Sequence

import grpc

from stiefel._wire.failures import from_rpc_error
from stiefel._wire.replies import require
from stiefel._wire.retries import Deadline, Pauses
from stiefel.errors import Closed, CorruptReply, DeadlineExceeded, StiefelError, Unimplemented
from stiefel.v1.simulation_pb2_grpc import SimulationServiceStub
from stiefel.version import __version__

WORK_PER_SECOND = 5e9  #: units of work (instructions) that a core does in a second
PATIENCE = 5.0  #: seconds that `close` waits for pauses and for gRPC's threads, which end within 0.4 s
Metadata = tuple[tuple[str, str], ...]

_open: "weakref.WeakSet[Connection]" = weakref.WeakSet()
_watched: "weakref.WeakSet[Any]" = weakref.WeakSet()  #: gRPC's states of the channels that were watched


class Connection:
    """The connection of a channel. It is closed at the latest when the process exits. Thread-safe."""

    def __init__(self, channel: grpc.Channel, address: str = "", timeout: Optional[float] = None, any_build: bool = False,
                 tls: Optional[bool] = None):
        """`timeout`: seconds of calls that do not get their own. `any_build`: whether sessions may go on at a server of
        another build. `tls`: whether the channel has TLS, if that is known."""
        self.address, self.timeout, self.any_build = address, timeout, any_build
        self._tls = tls
        self._channel = channel
        self._stub = SimulationServiceStub(channel)  # type: ignore[no-untyped-call]
        # Only this private attribute of gRPC tells whether the thread runs; without it there is no such thread.
        self._state = getattr(channel, "_connectivity_state", None)
        self._rest = getattr(channel, "rest", None)  # that of a channel of `stiefel.aio`, whose event loop goes on
        self._changed = threading.Condition()
        self._resting: set[threading.Event] = set()
        self.closed = False
        _open.add(self)

    @property
    def stub(self) -> SimulationServiceStub:
        """The gRPC stub of the service. Raises `Closed` after `close`."""
        if self.closed:
            raise self._closed_error()
        return self._stub

    def deadline(self, timeout: Optional[float]) -> Deadline:
        return Deadline(self.timeout if timeout is None else timeout)

    def call(self, method: str, request: Any, timeout: Optional[float] = None, metadata: Metadata = ()) -> Any:
        """Makes a unary call by name."""
        return self.repeat(lambda left: getattr(self.stub, method)(request, timeout=left, metadata=metadata),
                           self.deadline(timeout))

    def call_all(self, method: str, request: Any, timeout: Optional[float] = None) -> Sequence[Any]:
        """Makes a call with a stream of replies and returns all of them."""
        replies: Sequence[Any] = self.repeat(lambda left: tuple(getattr(self.stub, method)(request, timeout=left)),
                                             self.deadline(timeout))
        require(len(replies) > 0, f"{method} has no reply")
        return replies

    def repeat(self, attempt: Callable[[Optional[float]], Any], deadline: Deadline) -> Any:
        """Makes attempts of one call until one succeeds. `attempt` gets the seconds that are left."""
        waits = Pauses()
        while True:
            try:
                reply = attempt(deadline.left())
            except (grpc.RpcError, ValueError) as failure:
                error = self.error(failure)
            else:
                if reply is None:
                    raise CorruptReply("the server ended the call without a reply")
                return reply
            self.pause(error, waits, deadline)

    def pause(self, error: StiefelError, waits: Pauses, deadline: Deadline, late: bool = False) -> None:
        """Waits before the next attempt, or raises `error` if there is no further attempt. If that is because the
        deadline comes first and `late` is set, raises DeadlineExceeded instead."""
        wait = waits.after(error)
        if wait is None:
            raise deadline.explain(error) from None
        if deadline.comes_within(wait):
            if late:
                raise DeadlineExceeded(f"no time is left of {deadline.timeout:g} s: {error.message}") from error
            raise error from None
        self.rest(wait)

    def error(self, failure: Exception) -> StiefelError:
        """Returns this package's exception for one of gRPC's."""
        if self.closed:  # gRPC reports a closed channel with ValueError or CANCELLED
            return self._closed_error()
        if not isinstance(failure, grpc.RpcError):
            raise failure
        error = from_rpc_error(failure, self._tls)
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
        with self._changed:
            if self.closed:
                return
            self._resting.add(over)
            if self._state is not None:
                _watched.add(self._state)
        self._channel.subscribe(watch, try_to_connect=True)
        over.wait(seconds)
        self._channel.unsubscribe(watch)
        with self._changed:
            self._resting.discard(over)
            self._changed.notify_all()

    def sleep(self, seconds: float) -> None:
        """Waits for `seconds`."""
        (self._rest or threading.Event().wait)(seconds)

    def close(self) -> None:
        """Ends every `rest` and every call, and closes the channel when gRPC's thread that watches it has ended. On a
        closed channel that thread would print a ValueError to stderr."""
        with self._changed:
            self.closed = True
            for over in self._resting:
                over.set()
            self._changed.wait_for(lambda: not self._resting, PATIENCE)
        _wait_until(lambda: not _is_watched(self._state))
        self._channel.close()


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


def _exit() -> None:
    for connection in list(_open):
        connection.close()
    _wait_until(lambda: not any(map(_is_watched, list(_watched))))


def _forked() -> None:
    """Leaves the channels to the parent, whose threads the child does not have."""
    _open.clear()
    _watched.clear()


atexit.register(_exit)
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forked)
