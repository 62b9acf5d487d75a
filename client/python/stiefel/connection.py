"""The connection of a client, which is watched while its calls rest."""
from __future__ import annotations

import threading
import time

import grpc

PATIENCE = 1.0  #: seconds that `close` waits for gRPC's own thread, which ends within 0.4 s


class Connection:
    """Of a channel. Safe to use from many threads."""

    def __init__(self, channel: grpc.Channel):
        self._channel = channel
        self._changed = threading.Condition()
        self._resting: set[threading.Event] = set()
        self._closed = False

    def rest(self, seconds: float) -> None:
        """Waits that long, or until a channel that was not connected is, or until `close`. gRPC connects only while
        somebody watches the channel or calls, so sleeping would not do."""
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
        """Ends every rest, and waits until gRPC's thread has ended that watches the channel: on a closed channel it ends
        with a ValueError on stderr."""
        with self._changed:
            self._closed = True
            for over in self._resting:
                over.set()
            self._changed.wait_for(lambda: not self._resting, PATIENCE)
        end, pause = time.monotonic() + PATIENCE, threading.Event()
        while _is_watched(self._channel) and time.monotonic() < end:
            pause.wait(0.005)


def _is_watched(channel: grpc.Channel) -> bool:
    """gRPC tells this nowhere but in an attribute of its own; a channel without it has no such thread."""
    return bool(getattr(getattr(channel, "_connectivity_state", None), "polling", False))
