"""A server that this process starts on first use and keeps. It ends with the process, because it stops when its stdin ends.
A forked child starts its own: it uses neither the server nor the channel of its parent."""
from __future__ import annotations

import os
import threading
from typing import Callable, NamedTuple, Optional, TypeVar

from stiefel._client import Client
from stiefel._server import Server
from stiefel.errors import Closed, CorruptReply, DeadlineExceeded, NotFound, StiefelError, Unavailable

TIMEOUT = 600.0  #: seconds for one call; a chunk takes a few seconds
GONE = (Unavailable, NotFound, CorruptReply, DeadlineExceeded, Closed)  #: errors of a call that another server may answer
T = TypeVar("T")


class LostServer(StiefelError):
    """The server of a worker ended, could not be reached, or would compute other bits than the sweep's first server."""


class _Held(NamedTuple):
    server: Server
    client: Client

    def end(self) -> None:
        self.client.close()
        self.server.stop()


class Share(NamedTuple):
    """The part of the machine that a server may use."""

    threads: int  #: 0: all cores
    memory: Optional[int] = None  #: in bytes; None: the server's own default


class OwnServer:
    """A server of this process, started on first use. Thread-safe."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        #: By the process's id. A forked child keeps that of its parent, so that no destructor of gRPC runs in the child.
        self._by_process: dict[int, _Held] = {}

    def use(self, function: Callable[[Client], T], share: Share) -> T:
        """Calls `function` with a client of the server. If the server is gone, the next use starts another one."""
        held = self.hold(share)
        try:
            return function(held.client)
        except GONE:
            self.stop(held)
            raise

    def hold(self, share: Share) -> _Held:
        """Returns the server and its client, and starts the server with `share` if there is none or if it has ended.
        Raises Unavailable."""
        with self._lock:
            held = self._by_process.get(os.getpid())
            if held is not None and held.server.process.poll() is not None:
                held.end()
                held = None
            if held is None:
                memory = {} if share.memory is None else {"STIEFEL_MEMORY": str(share.memory)}
                server = Server.start(arguments=["--threads", str(share.threads)], environment=memory)
                held = self._by_process[os.getpid()] = _Held(server, Client(server.address, timeout=TIMEOUT))
                held.client._connection.waits = False  # a server that ends is replaced by another one
            return held

    def stop(self, held: Optional[_Held] = None) -> None:
        """Stops the server, which ends running calls, or `held` alone if it is still the server."""
        with self._lock:
            if held not in (None, self._by_process.get(os.getpid())):
                return
            held = self._by_process.pop(os.getpid(), None)
        if held is not None:
            held.end()
