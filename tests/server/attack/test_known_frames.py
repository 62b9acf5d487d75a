"""The frames of gRPC's CVEs of 2023: whatever they do, a supervisor has the server back with all that it stored.

Behind HAProxy they do not reach it; tests/replicas sends them through Envoy.

CVE-2023-1428: te, :scheme or grpclb_client_stats with another value than gRPC knows, in headers of more than 8 KiB.
CVE-2023-33953: strings, integers and headers in pieces that gRPC's HPACK parser reads before it looks at their size. It
reads them again with every piece, so that 4 MB take it 5 s and 1 MB a sixteenth of that: the test sends 1 MB.
CVE-2023-4785: more connections than the process has descriptors for.
"""
import contextlib
import os
import socket
import subprocess
import threading
from pathlib import Path

import grpc
import pytest

import stiefel
from authority import Authority
from conftest import BODY, Process, eventually
from daemons import find_daemon
from http2 import (ACK, CONTINUATION, END_HEADERS, END_STREAM, HEADERS, SETTINGS, START, call_headers, frame, header,
                   integer)

ROOT = next(folder for folder in Path(__file__).parents if (folder / "docker/haproxy.cfg").exists())
HAPROXY = find_daemon("haproxy")
MIB = 1 << 20
LARGE = header(b"x", b"y" * 9000)  # with what comes before it more than 8 KiB
FRAME = 16_000  # bytes, below HTTP/2's 16384


def in_frames(headers):
    """A call whose headers are cut into frames of the largest size."""
    first, *rest = [headers[at:at + FRAME] for at in range(0, len(headers), FRAME)]
    pieces = [frame(HEADERS, END_STREAM | (0 if rest else END_HEADERS), 1, first)]
    pieces += [frame(CONTINUATION, END_HEADERS if piece is rest[-1] else 0, 1, piece) for piece in rest]
    return b"".join(pieces)


def with_field(name, value):
    """The headers of a call in which that field has that value."""
    known = {b"te": header(b"te", b"trailers"), b":scheme": header(b":scheme", b"http")}.get(name)
    field = header(name, value)
    return call_headers().replace(known, field) if known else call_headers() + field


def unfinished(pieces):
    """HEADERS and then CONTINUATIONs, the last of which does not end the headers."""
    first, *rest = pieces
    return frame(HEADERS, END_STREAM, 1, first) + b"".join(frame(CONTINUATION, 0, 1, piece) for piece in rest)


BYTES = {
    "1428: te": in_frames(with_field(b"te", b"x") + LARGE),
    "1428: scheme": in_frames(with_field(b":scheme", b"x") + LARGE),
    "1428: grpclb_client_stats": in_frames(with_field(b"grpclb_client_stats", b"x") + LARGE),
    "1428: te twice": in_frames(call_headers() + header(b"te", b"x") + LARGE),
    "1428: te in the table": in_frames(call_headers() + header(b"te", b"x", indexed=True) + LARGE),
    "33953: a string of 2 GiB": unfinished([call_headers() + b"\0" + integer(1, 7) + b"x" + integer(1 << 31, 7),
                                            *[b"y" * FRAME] * 60]),
    "33953: an integer of 256 kB": unfinished([call_headers() + b"\0\x7f", *[b"\x80" * FRAME] * 16]),
    "33953: a header in pieces": unfinished([call_headers(), *[header(b"x-%d" % k, b"y" * 4000) * 3 for k in range(60)]]),
}


def say(address, data, acknowledge):
    """Sends it, reads what comes for a moment, and leaves. The server may hang up before.

    gRPC holds a client to its limit of headers from the moment at which the client has acknowledged its SETTINGS.
    """
    host, port = address.rsplit(":", 1)
    with contextlib.suppress(OSError), socket.create_connection((host, int(port)), timeout=60) as connection:
        connection.sendall(START)
        if acknowledge:
            connection.recv(65536)
            connection.sendall(frame(SETTINGS, ACK))
        connection.settimeout(0.2)
        for at in range(0, len(data), MIB):
            connection.sendall(data[at:at + MIB])
        while connection.recv(65536):
            pass


def many_connections(address):
    """More than the server has descriptors for, at once."""
    host, port = address.rsplit(":", 1)
    held = []
    for _ in range(600):
        with contextlib.suppress(OSError):
            held.append(socket.create_connection((host, int(port)), timeout=2))
    for connection in held:
        connection.close()


def say_both(data):
    def attack(address):
        for acknowledge in (True, False):
            say(address, data, acknowledge)
    return attack


ATTACKS = {name: say_both(data) for name, data in BYTES.items()}
ATTACKS["4785: 600 connections"] = many_connections


class Supervised:
    """A server with a store at one address; whenever it ends another one starts 100 ms later, as with RestartSec=100ms."""

    def __init__(self, store):
        self.arguments = ("--store", str(store), "--log-level", "off", "--memory", "256M")
        self.process = Process(*self.arguments, descriptors=(256, 256))
        self.address, self.starts = self.process.address, 1
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._restart)
        self._thread.start()

    def _restart(self):
        while not self._over.is_set():
            if self.process.child.poll() is None:
                self._over.wait(0.01)
                continue
            self._over.wait(0.1)
            try:
                self.process = Process(*self.arguments, listen=self.address, descriptors=(256, 256))
                self.starts += 1
            except AssertionError:  # the port is not free yet
                pass

    def stop(self):
        self._over.set()
        self._thread.join()
        return self.process.stop()


@pytest.fixture
def supervised(tmp_path):
    server = Supervised(tmp_path / "store")
    yield server
    server.stop()


class Kept:
    """Sessions that were acknowledged, and the bits of a state of each."""

    def __init__(self, address):
        self.address, self.bits = address, {}

    def create(self, client):
        session = client.create({**BODY, "step": 0.01 + 1e-5 * len(self.bits)})
        self.bits[session.id] = session.step(to=100, fields="Q")["Q"].tobytes()

    def there(self):
        """Whether the server answers, with every session and its bits; other bits are an error."""
        try:
            with stiefel.Client(self.address) as client:
                for id, bits in self.bits.items():
                    assert client.get(id).step(to=100, fields="Q")["Q"].tobytes() == bits
                assert {session.id for session in client.list()} == self.bits.keys()
        except (stiefel.Unavailable, grpc.RpcError):
            return False
        return True


def attack(kept, name, address):
    """One more session is acknowledged just before the attack; afterwards all are there again."""
    with stiefel.Client(kept.address) as client:
        kept.create(client)
    ATTACKS[name](address)
    assert eventually(kept.there), name


def test_bare_the_server_is_back_with_all_that_was_stored(supervised):
    kept = Kept(supervised.address)
    for name in ATTACKS:
        starts = supervised.starts
        attack(kept, name, supervised.address)
        print(f"{name}: all there after {supervised.starts - starts} restarts")
    assert len(kept.bits) == len(ATTACKS)


def free_port():
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return one.getsockname()[1]


@pytest.fixture
def proxy(supervised, tmp_path):
    """The address of HAProxy with docker/haproxy.cfg before the supervised server."""
    local, tls = free_port(), free_port()
    identity, pem = Authority(tmp_path).issue(), tmp_path / "stiefel.pem"
    pem.write_text(Path(identity.certificate).read_text() + Path(identity.key).read_text())
    environment = {**os.environ, **{f"STIEFEL_REPLICAS_{k}": supervised.address for k in (1, 2, 3)},
                   "STIEFEL_LOCAL_BIND": f"127.0.0.1:{local}", "STIEFEL_TLS_BIND": f"127.0.0.1:{tls}",
                   "STIEFEL_CERTIFICATE": str(pem)}
    haproxy = subprocess.Popen([HAPROXY, "-db", "-f", ROOT / "docker/haproxy.cfg"], env=environment,
                               stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    address = f"127.0.0.1:{local}"

    def served():
        try:
            with stiefel.Client(address) as client:
                return bool(client.describe().version)
        except (stiefel.StiefelError, grpc.RpcError):
            return False
    try:
        assert eventually(served)
        yield address
    finally:
        haproxy.terminate()
        haproxy.wait()


@pytest.mark.skipif(HAPROXY is None, reason="needs Debian's haproxy")
def test_behind_haproxy_the_server_does_not_notice(supervised, proxy):
    kept, child = Kept(proxy), supervised.process.child
    for name in ATTACKS:
        attack(kept, name, proxy)
        assert supervised.starts == 1 and child.poll() is None, name
    assert supervised.process.memory() < 256 * MIB
