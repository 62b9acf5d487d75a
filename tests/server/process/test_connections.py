"""Connections: many, silent, broken. Whatever they do, the next client is served or told that it is not."""
import json
import os
import resource
import time

import grpc
import pytest

from conftest import PREFACE, SANITIZED, eventually
from stiefel import v1 as pb
from stiefel.v1 import simulation_pb2_grpc as rpc

def describe(process, timeout=60):
    with process.channel() as channel:
        return rpc.SimulationServiceStub(channel).Describe(pb.DescribeRequest(), timeout=timeout, wait_for_ready=True)


@pytest.fixture(params=["tcp", "unix"])
def listen(request, tmp_path):
    return "127.0.0.1:0" if request.param == "tcp" else f"unix:{tmp_path}/socket"


@pytest.fixture
def all_descriptors():
    """Raises the soft limit of the tests' own descriptors, 1024 in a login shell, to the hard limit."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (hard, hard))
    yield
    resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))


def test_more_connections_than_descriptors(serve, listen, all_descriptors):
    """Those beyond the limit are closed at once. A client comes in when the silent ones have had their ten seconds."""
    process = serve("--log-format", "json", listen=listen, descriptors=(256, 256))
    silent = [process.connect() for _ in range(300)]
    assert describe(process).version
    assert process.open_descriptors() < 256
    for connection in silent:
        connection.close()
    process.stop()
    refused = [line for line in process.child.stderr.read().splitlines() if "connections refused" in line]
    assert sum(json.loads(line)["count"] for line in refused) >= 1


def test_the_soft_limit_of_descriptors_is_raised(serve):
    process = serve(descriptors=(256, 2048))
    assert resource.prlimit(process.child.pid, resource.RLIMIT_NOFILE) == (2048, 2048)


@pytest.mark.skipif(SANITIZED, reason="the check of virtual tables makes pipes itself")
def test_without_a_descriptor_connections_wait(serve):
    process = serve()
    held, _ = process.speaking()
    limit = resource.prlimit(process.child.pid, resource.RLIMIT_NOFILE)
    # The limit is on the next number, and numbers are given from below.
    next_number = max(int(number) for number in os.listdir(f"/proc/{process.child.pid}/fd")) + 1
    resource.prlimit(process.child.pid, resource.RLIMIT_NOFILE, (next_number, limit[1]))
    waiting = [process.connect() for _ in range(8)]
    held.settimeout(1)
    with pytest.raises(TimeoutError):
        while held.recv(100):  # empty would be the end
            pass
    resource.prlimit(process.child.pid, resource.RLIMIT_NOFILE, limit)
    for connection in waiting:
        connection.settimeout(60)
        connection.sendall(PREFACE)
        assert connection.recv(4096)
    assert describe(process).version
    held.close()


def test_a_silent_connection_is_closed_after_ten_seconds(serve):
    process = serve()
    silent, start = process.connect(), time.monotonic()
    silent.settimeout(60)
    while silent.recv(4096):  # the server's SETTINGS
        pass
    assert 9 < time.monotonic() - start


@pytest.mark.parametrize("garbage", [b"GET / HTTP/1.1\r\nHost: x\r\n\r\n", b"\0" * 10_000, os.urandom(10_000),
                                     PREFACE[:10], PREFACE + b"\xff" * 1000, PREFACE + b"\0\0\x08\x06\0\0\0\0\0" + b"x" * 7,
                                     PREFACE * 50], ids=range(7))
def test_bytes_that_are_no_http(serve, garbage):
    process = serve()
    for _ in range(20):
        connection = process.connect()
        connection.sendall(garbage)
        connection.close()
    assert describe(process).version and process.child.poll() is None


GOAWAY = 7  # a type of HTTP/2's frames


def frames(data):
    """The types of the frames that are there whole."""
    while len(data) >= 9 + int.from_bytes(data[:3], "big"):
        yield data[3]
        data = data[9 + int.from_bytes(data[:3], "big"):]


def test_an_old_connection_is_replaced_and_no_call_fails(serve):
    process = serve("--max-connection-age", "0.3")
    old, data = process.speaking()
    while GOAWAY not in frames(data):
        data += old.recv(4096)
    with process.channel() as channel:
        stub, end = rpc.SimulationServiceStub(channel), time.monotonic() + 2
        while time.monotonic() < end:
            assert stub.Describe(pb.DescribeRequest(), timeout=60).version
            time.sleep(0.02)  # each call writes a line into a pipe that nobody reads


def test_ten_thousand_connections_come_and_go(serve):
    process = serve(descriptors=(1024, 1024))
    describe(process)
    before = process.open_descriptors()
    for _ in range(100):
        some = [process.connect() for _ in range(100)]
        for connection in some[::2]:
            connection.sendall(PREFACE)
        for connection in some:
            connection.close()
    assert describe(process).version
    assert eventually(lambda: process.open_descriptors() <= before + 5)
