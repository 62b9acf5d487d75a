"""A socket between client and server that does to the bytes what networks do: `FaultSocket(address, fault)`."""
import contextlib
import socket
import struct
import threading

CHUNK = 65536


def plain(source, target, _):
    while data := source.recv(CHUNK):
        target.sendall(data)


class Ends:
    """After a number of bytes in all, by `how`: "reset", "close" or "silence" (nothing comes any more)."""

    def __init__(self, how, limit):
        self.how, self.limit = how, limit

    def __call__(self, source, target, pair):
        while data := source.recv(CHUNK):
            with pair.lock:
                passed = data[:max(self.limit - pair.passed, 0)]
                pair.passed += len(passed)
                over = pair.passed >= self.limit
            if passed:
                target.sendall(passed)
            if over and self.how == "reset":
                pair.reset()
            if over and self.how == "close":
                return
            if over and self.how == "silence":
                pair.ended.wait(60)
                return


class Hole:
    """From `swallow()` on, nothing comes through the connections that exist, and nobody hears of it. Later ones pass."""

    def __init__(self):
        self._swallowed = 0

    def swallow(self):
        self._swallowed += 1

    def __call__(self, source, target, pair):
        begun = self._swallowed
        while data := source.recv(CHUNK):
            if self._swallowed > begun:
                pair.ended.wait()
                return
            target.sendall(data)


class Pair:
    def __init__(self, near, far):
        self.near, self.far = near, far
        self.lock, self.passed, self.ended = threading.Lock(), 0, threading.Event()

    def reset(self):
        """RST instead of FIN, to both sides."""
        for one in (self.near, self.far):
            with contextlib.suppress(OSError):
                one.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        self.close()

    def close(self):
        self.ended.set()
        for one in (self.near, self.far):
            with contextlib.suppress(OSError):
                one.shutdown(socket.SHUT_RDWR)
            one.close()


class FaultSocket:
    """Listens on `address` and passes bytes on to `target` through `fault`, a function (source, target, pair).

    `connections` is how many the fault is done to; those after them pass as they are. None: all.
    """

    def __init__(self, target, fault, connections=None):
        self._target, self._fault, self._left = target, fault, connections
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.address = "127.0.0.1:%d" % self._listener.getsockname()[1]
        self._pairs = []
        threading.Thread(target=self._accept, daemon=True).start()

    def _accept(self):
        while True:
            try:
                near, _ = self._listener.accept()
            except OSError:
                return
            fault = self._fault
            if self._left is not None:
                self._left -= 1
                if self._left < 0:
                    fault = plain
            host, port = self._target.rsplit(":", 1)
            try:
                pair = Pair(near, socket.create_connection((host, int(port))))
            except OSError:
                near.close()
                continue
            self._pairs.append(pair)
            for one, other in ((pair.near, pair.far), (pair.far, pair.near)):
                threading.Thread(target=self._pass, args=(fault, one, other, pair), daemon=True).start()

    @staticmethod
    def _pass(fault, source, target, pair):
        with contextlib.suppress(OSError, ValueError):
            fault(source, target, pair)
        pair.close()

    def close(self):
        self._listener.close()
        for pair in self._pairs:
            pair.close()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()
