"""A server that this process starts on first use and keeps.

The server ends with the process, because it stops when its stdin ends. A forked child starts its own: it uses neither
the server nor the channel of its parent.
"""
from __future__ import annotations

import os
import socket
import threading
import weakref
from typing import Callable, NamedTuple, Optional, TypeVar

from stiefel.client import Client
from stiefel.errors import Closed, Unavailable
from stiefel.server import Server
from stiefel._sweep.failures import LostServer

TIMEOUT = 600.0  #: seconds for one call; a chunk takes a few seconds
T = TypeVar("T")


class _Held(NamedTuple):
    server: Server
    client: Client


class Share(NamedTuple):
    """The part of the machine that a server may use."""

    threads: int  #: 0: all cores
    memory: Optional[int] = None  #: in bytes; None: the server's own default


_all: "weakref.WeakSet[OwnServer]" = weakref.WeakSet()
_inherited: list[_Held] = []  # the parent's servers, kept so that no destructor of gRPC runs in the child


class OwnServer:
    """A server of this process, started on first use. Thread-safe."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._held: Optional[_Held] = None
        _all.add(self)

    def use(self, function: Callable[[Client], T], share: Share) -> T:
        """Calls `function` with a client of the server, and starts the server with `share` if there is none. If
        `function` raises LostServer, stops the server, so that the next use starts another one, and raises it again."""
        try:
            held = self.hold(share)
        except Unavailable as error:
            raise LostServer(f"on {socket.gethostname()}: {error.message}") from None
        try:
            return function(held.client)
        except LostServer:
            self._drop(held)
            raise
        except Closed as error:  # another thread has lost the server and closed the client
            raise LostServer(error.message) from None

    def stop(self) -> None:
        """Stops the server. The next use starts another one."""
        held = self._held
        if held is not None:
            self._drop(held)

    def hold(self, share: Share) -> _Held:
        """Returns the server and its client, and starts the server with `share` if there is none or if it has ended.
        Raises Unavailable."""
        with self._lock:
            if self._held is not None and self._held.server.process.poll() is not None:
                _end(self._held)
                self._held = None
            if self._held is None:
                server = Server.start(arguments=["--threads", str(share.threads)], environment=_memory(share))
                client = Client(server.address, timeout=TIMEOUT)
                client._connection.waits = False  # a server that ends is replaced by another one
                self._held = _Held(server, client)
            return self._held

    def _drop(self, held: _Held) -> None:
        """Stops the server `held`, unless another thread has already done so."""
        with self._lock:
            if self._held is not held:
                return
            self._held = None
        _end(held)

    def forget(self) -> None:
        """Call this in a forked child, because the server and the channel are the parent's."""
        self._lock = threading.Lock()
        if self._held is not None:
            _inherited.append(self._held)
            self._held = None


def _memory(share: Share) -> dict[str, str]:
    return {} if share.memory is None else {"STIEFEL_MEMORY": str(share.memory)}


def _end(held: _Held) -> None:
    held.client.close()
    held.server.stop()


def _forked() -> None:
    for own in list(_all):
        own.forget()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forked)
