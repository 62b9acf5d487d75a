"""Calls written by hand that a sound client cannot send: the server lives and serves others; and the frames of gRPC's CVEs
of 2023: whatever they do, a supervisor has the server back with all that it stored.

tests/replicas sends these frames, and floods, through the proxies, where they do not reach a server.

CVE-2023-1428: te, :scheme or grpclb_client_stats with another value than gRPC knows, in headers of more than 8 KiB.
CVE-2023-33953: strings, integers and headers in pieces that gRPC's HPACK parser reads before it looks at their size. It
reads them again with every piece, so that 4 MB take it 5 s and 1 MB a sixteenth of that: the test sends 1 MB.
CVE-2023-4785: more connections than the process has descriptors for.
"""
import contextlib
import random
import socket
import threading

import grpc
import pytest

import stiefel
from conftest import BODY, Process, eventually
from http2 import (CONTINUATION, DATA, EMPTY_MESSAGE, END_HEADERS, END_STREAM, HEADERS, PREFACE, SETTINGS, START, call,
                   call_headers, frame, header, integer, say)
from stiefel import v1 as pb
from stiefel.v1 import simulation_pb2_grpc as rpc

MIB = 1 << 20
LARGE = header(b"x", b"y" * 9000)  # with what comes before it more than 8 KiB
FRAME = 16_000  # bytes, below HTTP/2's 16384


def in_frames(headers):
    """A call whose headers are cut into frames of the largest size."""
    first, *rest = [headers[at:at + FRAME] for at in range(0, len(headers), FRAME)]
    pieces = [frame(HEADERS, END_STREAM | (0 if rest else END_HEADERS), 1, first)]
    pieces += [frame(CONTINUATION, END_HEADERS if piece is rest[-1] else 0, 1, piece) for piece in rest]
    return START + b"".join(pieces)


def with_field(name, value):
    """The headers of a call in which that field has that value."""
    known = {b"te": header(b"te", b"trailers"), b":scheme": header(b":scheme", b"http")}.get(name)
    field = header(name, value)
    return call_headers().replace(known, field) if known else call_headers() + field


def unfinished(pieces):
    """HEADERS and then CONTINUATIONs, the last of which does not end the headers."""
    first, *rest = pieces
    return START + frame(HEADERS, END_STREAM, 1, first) + b"".join(frame(CONTINUATION, 0, 1, piece) for piece in rest)


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
            say(address, data, acknowledge, 0.2)
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


LIMIT = 256 * MIB
DESCRIBE, CREATE = b"/stiefel.v1.SimulationService/Describe", b"/stiefel.v1.SimulationService/CreateSession"

WRONG = {
    "HTTP/1.1": b"GET / HTTP/1.1\r\nHost: x\r\n\r\n",
    "zeros": b"\0" * 10_000,
    "noise": random.Random(1).randbytes(10_000),
    "half a preface": PREFACE[:10],
    "fifty prefaces": PREFACE * 50,
    "frames of no type": PREFACE + b"\xff" * 1000,
    "a ping of 7 bytes": PREFACE + b"\0\0\x08\x06\0\0\0\0\0" + b"x" * 7,
    "a window of 0 and then a call": (START + frame(SETTINGS, 0, 0, b"\0\4\0\0\0\0") +
                                      frame(HEADERS, END_HEADERS, 1, call_headers()) + EMPTY_MESSAGE),
    "no path": call(header(b":method", b"POST")),
    "a path of 16 kB": call(call_headers(b"/" + b"x" * 100_000)[:16_000]),
    "a method that is not there": call(call_headers(b"/stiefel.v1.SimulationService/Nothing")),
    "a deadline that is no number": call(call_headers(DESCRIBE, (b"grpc-timeout", b"99999999999999999999H"))),
    "a message that says it has 4 GiB": call(call_headers(), frame(DATA, END_STREAM, 1, b"\0\xff\xff\xff\xff" + b"x")),
    "a message cut in its length": call(call_headers(), frame(DATA, END_STREAM, 1, b"\0\0\0")),
    "a compressed message": call(call_headers(), frame(DATA, END_STREAM, 1, b"\1\0\0\0\4abcd")),
    "a message that is no protobuf": call(call_headers(CREATE), frame(DATA, END_STREAM, 1, b"\0\0\0\0\4\xff\xff\xff\xff")),
}


@pytest.fixture(scope="module")
def process():
    """One server for all attacks of this file: it has to survive them together."""
    server = Process("--log-level", "error", "--memory", f"{LIMIT >> 20}M")
    yield server
    assert server.stop() == 0


def served(address):
    with stiefel.Client(address) as client:
        return bool(client.describe().version)


def test_what_breaks_the_rules(process):
    for name, data in WRONG.items():
        for _ in range(3):
            say(process.address, data, False, 0.02)
        assert served(process.address), name


def test_random_frames(process):
    """Frames with random types, flags, streams and payloads behind a sound start, some cut short."""
    random_ = random.Random(20)
    for _ in range(200):
        parts = [START]
        for _ in range(random_.randrange(1, 12)):
            kind = random_.choice([*range(10), random_.randrange(256)])
            payload = random_.randbytes(random_.randrange(200))
            if kind == HEADERS and random_.random() < 0.7:
                payload = call_headers()
            length = len(payload) if random_.random() < 0.9 else random_.randrange(1 << 24)
            parts.append(frame(kind, random_.randrange(256), random_.choice([0, 1, 3, random_.randrange(1 << 31)]),
                               payload, length))
        data = b"".join(parts)
        say(process.address, data[:random_.randrange(len(PREFACE), len(data) + 1)], False, 0.02)
    assert served(process.address)
    assert process.memory() < 1.2 * LIMIT


def test_metadata_beyond_the_limit_is_refused(process):
    """gRPC's limit is 8 KiB. Far beyond it the connection ends too."""
    for size in (20_000, 1_000_000):
        with process.channel() as channel, pytest.raises(grpc.RpcError) as refused:
            rpc.SimulationServiceStub(channel).Describe(pb.DescribeRequest(), timeout=30, metadata=[("x", "y" * size)])
        assert refused.value.code() in (grpc.StatusCode.RESOURCE_EXHAUSTED, grpc.StatusCode.UNAVAILABLE)
    with process.channel() as channel:
        assert rpc.SimulationServiceStub(channel).Describe(
            pb.DescribeRequest(), timeout=30, metadata=[(f"x{n}", "y") for n in range(100)]).version
