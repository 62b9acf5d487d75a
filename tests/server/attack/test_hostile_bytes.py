"""Bytes that break HTTP/2's rules or use them to the full: the server lives, serves others, and holds little memory.

The frames of CVE-2023-1428, CVE-2023-4785 and CVE-2023-33953 are in test_known_frames.py.
"""
import contextlib
import random
import select
import socket

import grpc
import pytest

from conftest import Process, eventually
from http2 import (CONTINUATION, DATA, EMPTY_MESSAGE, END_HEADERS, END_STREAM, GOAWAY, HEADERS, PING, PREFACE, PRIORITY,
                   PUSH_PROMISE, RST_STREAM, SETTINGS, START, WINDOW_UPDATE, call, call_headers, frame, header, integer)
from stiefel import v1 as pb
from stiefel.v1 import simulation_pb2_grpc as rpc

MIB = 1 << 20
LIMIT = 256 * MIB
OPEN = frame(HEADERS, END_HEADERS, 1, call_headers())

WRONG = {
    "a frame that is longer than the limit": START + frame(DATA, 0, 1, b"x" * 100, length=0xFFFFFF),
    "a frame that never ends": START + frame(HEADERS, END_HEADERS, 1, b"x", length=16000),
    "an unknown frame": START + frame(99, 255, 7, b"?" * 1000) * 100,
    "data on a stream that is not open": START + frame(DATA, 0, 9, b"x" * 1000) * 100,
    "an even stream": START + frame(HEADERS, END_HEADERS, 2, call_headers()),
    "streams in falling order": START + b"".join(frame(HEADERS, END_HEADERS, n, call_headers()) for n in (9, 7, 5)),
    "headers on stream 0": START + frame(HEADERS, END_HEADERS, 0, call_headers()),
    "a stream that depends on itself": START + frame(PRIORITY, 0, 1, b"\0\0\0\1\20") * 1000,
    "a promise of a client": START + frame(PUSH_PROMISE, END_HEADERS, 1, b"\0\0\0\2" + call_headers()),
    "settings of half a parameter": START + frame(SETTINGS, 0, 0, b"\0\1\0"),
    "a setting out of range": START + frame(SETTINGS, 0, 0, b"\0\4\xff\xff\xff\xff"),
    "a frame size of one byte": START + frame(SETTINGS, 0, 0, b"\0\5\0\0\0\1") + OPEN,
    "a window of 0 and then a call": START + frame(SETTINGS, 0, 0, b"\0\4\0\0\0\0") + OPEN + EMPTY_MESSAGE,
    "a window that overflows": START + frame(WINDOW_UPDATE, 0, 0, b"\x7f\xff\xff\xff") * 3,
    "a window update of 0": START + frame(WINDOW_UPDATE, 0, 0, b"\0\0\0\0"),
    "a ping of 3 bytes": START + frame(PING, 0, 0, b"abc"),
    "a goodbye in the middle": START + OPEN + frame(GOAWAY, 0, 0, b"\0\0\0\0\0\0\0\2debug") + EMPTY_MESSAGE,
    "headers in pieces with a ping between": START + frame(HEADERS, 0, 1, call_headers()) + frame(PING, 0, 0, b"x" * 8),
    "a header of an index that is not there": call(integer(5000, 7, 0x80)),
    "an integer of twenty bytes": call(b"\x7f" + b"\xff" * 20),
    "a header longer than its frame": call(b"\0" + integer(70000, 7) + b"x"),
    "a Huffman code of ones": call(b"\0\x81\xff\x84\xff\xff\xff\xff"),
    "no path": call(header(b":method", b"POST")),
    "two paths": call(call_headers() + header(b":path", b"/x")),
    "a path of 100 kB": call(call_headers(b"/" + b"x" * 100_000)[:16_000]),
    "a method that is not there": call(call_headers(b"/stiefel.v1.SimulationService/Nothing")),
    "GET": call(call_headers().replace(header(b":method", b"POST"), header(b":method", b"GET"))),
    "a deadline that is no number": call(call_headers(b"/stiefel.v1.SimulationService/Describe",
                                                      (b"grpc-timeout", b"99999999999999999999H"))),
    "a message that says it has 4 GiB": call(call_headers(), frame(DATA, END_STREAM, 1, b"\0\xff\xff\xff\xff" + b"x")),
    "a message cut in its length": call(call_headers(), frame(DATA, END_STREAM, 1, b"\0\0\0")),
    "a compressed message": call(call_headers(), frame(DATA, END_STREAM, 1, b"\1\0\0\0\4abcd")),
    "a message that is no protobuf": call(call_headers(b"/stiefel.v1.SimulationService/CreateSession"),
                                          frame(DATA, END_STREAM, 1, b"\0\0\0\0\4\xff\xff\xff\xff")),
    "data longer than padding allows": START + OPEN + frame(DATA, 8, 1, b"\xff" + b"x" * 10),
    "half a preface": PREFACE[:11],
    "the preface twice": PREFACE + PREFACE,
}

# What a caller can send without end, as (what comes first, what is repeated, how many times).
FLOODS = {
    "pings": (START, frame(PING, 0, 0, b"12345678"), 20_000),
    "settings": (START, frame(SETTINGS, 0, 0, b"\0\3\0\0\0\x64"), 20_000),
    "empty data": (START + OPEN, frame(DATA, 0, 1), 50_000),
    "window updates": (START + OPEN, frame(WINDOW_UPDATE, 0, 1, b"\0\0\0\1"), 50_000),
    "priorities": (START, frame(PRIORITY, 0, 3, b"\0\0\0\1\20"), 50_000),
    "headers that go on": (START + frame(HEADERS, 0, 1, call_headers()),
                           frame(CONTINUATION, 0, 1, header(b"x", b"y" * 100) * 50), 2000),
    "headers in the table": (START, None, 2000),
    "calls": (START, None, 5000),
}


def repeated(what, unit, n):
    stream = 2 * n + 1
    if what == "headers in the table":
        field = header(b"name-%d" % n, b"v" * 3000, indexed=True)
        return frame(HEADERS, END_HEADERS | END_STREAM, stream, call_headers() + field)
    if what == "streams that are reset":
        return frame(HEADERS, END_HEADERS, stream, call_headers()) + frame(RST_STREAM, 0, stream, b"\0\0\0\x08")
    if what == "calls":
        return (frame(HEADERS, END_HEADERS, stream, call_headers()) +
                frame(DATA, END_STREAM, stream, b"\0\0\0\0\0"))
    return unit


@pytest.fixture(scope="module")
def process():
    """One server for all attacks of this file: it has to survive them together."""
    server = Process("--log-level", "error", "--memory", f"{LIMIT // MIB}M")
    yield server
    assert server.stop() == 0


def check_served(process):
    with process.channel() as channel:
        assert rpc.SimulationServiceStub(channel).Describe(pb.DescribeRequest(), timeout=30).version


def say(process, data):
    """Sends it, reads for a moment, and leaves without a word. The server may hang up before."""
    connection = process.connect()
    connection.settimeout(0.02)
    with contextlib.suppress(OSError):
        connection.sendall(data)
        connection.shutdown(socket.SHUT_WR)
        while connection.recv(65536):
            pass
    connection.close()


@pytest.mark.parametrize("name", WRONG)
def test_what_breaks_the_rules(process, name):
    for _ in range(3):
        say(process, WRONG[name])
    check_served(process)


def flood(process, name, first, unit, count):
    check_served(process)
    connection = process.connect()
    connection.settimeout(5)
    with contextlib.suppress(OSError):  # the server may end the connection at any time
        connection.sendall(first)
        for start in range(0, count, 100):
            connection.sendall(b"".join(repeated(name, unit, n) for n in range(start, start + 100)))
            while select.select([connection], [], [], 0)[0] and connection.recv(1 << 16):
                pass
        check_served(process)
    connection.close()
    check_served(process)


@pytest.mark.parametrize("name", FLOODS)
def test_floods(process, name):
    flood(process, name, *FLOODS[name])
    assert process.memory() < 1.2 * LIMIT


def test_streams_that_are_reset(serve):
    """gRPC 1.51 holds 16 kB for each until it has seen the reset, which --memory does not bound; they go back."""
    process = serve("--log-level", "error", "--memory", f"{LIMIT // MIB}M")
    flood(process, "streams that are reset", START, None, 20_000)
    assert eventually(lambda: process.resident() < 0.5 * LIMIT), process.resident() / MIB


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
        say(process, data[:random_.randrange(len(PREFACE), len(data) + 1)])
    check_served(process)
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
