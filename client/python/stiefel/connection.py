"""Pauses between the attempts of a client's calls, which end when the channel connects; and the end of a channel.

While a pause watches the channel, gRPC polls it in a thread that ends 0.2 s after the pause. An interpreter that ends
before that thread never exits, so the exit waits for it, also where the client is gone already.
"""
from __future__ import annotations

import atexit
import os
import threading
import time
import weakref
from typing import Any, Callable

import grpc

PATIENCE = 5.0  #: seconds that `close` waits for pauses and for gRPC's threads, which end within 0.4 s

_open: "weakref.WeakSet[Connection]" = weakref.WeakSet()
_watched: "weakref.WeakSet[Any]" = weakref.WeakSet()  #: gRPC's states of the channels that were watched


class Connection:
    """The connection of a channel. It is closed at the latest when the process exits. Thread-safe."""

    def __init__(self, channel: grpc.Channel):
        self._channel = channel
        # Only this private attribute of gRPC tells whether the thread runs; without it there is no such thread.
        self._state = getattr(channel, "_connectivity_state", None)
        self._changed = threading.Condition()
        self._resting: set[threading.Event] = set()
        self.closed = False
        _open.add(self)

    def rest(self, seconds: float) -> None:
        """Waits for `seconds`, or until a disconnected channel has connected, or until `close`. It does not simply
        sleep, because gRPC connects only while the channel is watched or a call runs."""
        over = threading.Event()
        seen: list[grpc.ChannelConnectivity] = []

        def watch(state: grpc.ChannelConnectivity) -> None:
            if state is grpc.ChannelConnectivity.READY and seen:
                over.set()
            seen.append(state)

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
