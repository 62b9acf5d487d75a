"""Pauses between the attempts of a client's calls, which end when the channel connects."""
from __future__ import annotations

import threading
import time

import grpc

PATIENCE = 1.0  #: seconds that `close` waits for gRPC's own thread, which ends within 0.4 s


class Connection:
    """The connection of a channel. Thread-safe."""

    def __init__(self, channel: grpc.Channel):
        self._channel = channel
        self._changed = threading.Condition()
        self._resting: set[threading.Event] = set()
        self._closed = False

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
            if self._closed:
                return
            self._resting.add(over)
        self._channel.subscribe(watch, try_to_connect=True)
        over.wait(seconds)
        self._channel.unsubscribe(watch)
        with self._changed:
            self._resting.discard(over)
            self._changed.notify_all()

    def close(self) -> None:
        """Ends every `rest`, and waits until gRPC's thread that watches the channel has ended. On a closed channel that
        thread would print a ValueError to stderr."""
        with self._changed:
            self._closed = True
            for over in self._resting:
                over.set()
            self._changed.wait_for(lambda: not self._resting, PATIENCE)
        end, pause = time.monotonic() + PATIENCE, threading.Event()
        while _is_watched(self._channel) and time.monotonic() < end:
            pause.wait(0.005)


def _is_watched(channel: grpc.Channel) -> bool:
    """Returns whether gRPC's thread that watches the channel runs. Only a private attribute of gRPC tells; a channel
    without the attribute has no such thread."""
    return bool(getattr(getattr(channel, "_connectivity_state", None), "polling", False))
