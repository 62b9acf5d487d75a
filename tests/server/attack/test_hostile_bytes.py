"""Calls written by hand that a sound client cannot send: the server lives and serves others.

The frames of gRPC's CVEs are in test_known_frames.py; floods go through the proxies, in tests/replicas.
"""
import contextlib
import random
import socket

import grpc
import pytest

from conftest import Process
from http2 import (DATA, EMPTY_MESSAGE, END_HEADERS, END_STREAM, HEADERS, PREFACE, SETTINGS, START, call, call_headers, frame,
                   header)
from stiefel import v1 as pb
from stiefel.v1 import simulation_pb2_grpc as rpc

LIMIT = 256 << 20  # bytes
DESCRIBE, CREATE = b"/stiefel.v1.SimulationService/Describe", b"/stiefel.v1.SimulationService/CreateSession"

WRONG = {
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
