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

NO_PLACE = b"HTTP/1.1 503 "


def describe(process, timeout=60):
    with process.channel() as channel:
        return rpc.SimulationServiceStub(channel).Describe(pb.DescribeRequest(), timeout=timeout)


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


def test_1100_silent_connections_with_1024_descriptors(serve, listen, all_descriptors):
    process = serve(listen=listen, descriptors=(1024, 1024))
    silent = [process.connect() for _ in range(1100)]
    assert describe(process).version
    assert process.open_descriptors() < 1024
    for connection in silent:
        connection.close()
    assert describe(process).version


def test_the_soft_limit_of_descriptors_is_raised(serve):
    process = serve(descriptors=(256, 2048))
    assert resource.prlimit(process.child.pid, resource.RLIMIT_NOFILE) == (2048, 2048)


def test_a_connection_beyond_the_limit_is_refused_and_the_others_stay(serve, listen):
    process = serve("--max-connections", "4", listen=listen)
    open_, answers = zip(*(process.speaking() for _ in range(4)))
    assert all(answer and not answer.startswith(NO_PLACE) for answer in answers)
    late, answer = process.speaking()
    assert answer.startswith(NO_PLACE + b"too many connections")
    assert late.recv(100) == b""
    with pytest.raises(grpc.RpcError) as refused:
        describe(process)
    assert refused.value.code() == grpc.StatusCode.UNAVAILABLE
    open_[0].close()
    assert eventually(lambda: not process.speaking()[1].startswith(NO_PLACE))
    for connection in open_[1:]:
        connection.setblocking(False)
        with pytest.raises(BlockingIOError):
            while connection.recv(100):  # empty would be the end
                pass


def test_a_refused_client_does_not_come_back_at_once(serve):
    """It counts its attempts: gRPC's pauses grow from one second."""
    process = serve("--max-connections", "1", "--log-format", "json")
    connection, _ = process.speaking()
    with process.channel() as channel:
        stub = rpc.SimulationServiceStub(channel)
        with pytest.raises(grpc.RpcError):
            stub.Describe(pb.DescribeRequest(), timeout=2.5, wait_for_ready=True)
    connection.close()
    process.stop()
    refused = [line for line in process.child.stderr.read().splitlines() if "connections refused" in line]
    assert 1 <= sum(json.loads(line)["count"] for line in refused) <= 4


@pytest.mark.skipif(SANITIZED, reason="the check of virtual tables makes pipes itself")
def test_without_a_descriptor_a_connection_is_told_so(serve):
    process = serve()
    held, _ = process.speaking()
    limit = resource.prlimit(process.child.pid, resource.RLIMIT_NOFILE)
    # The limit is on the next number, and numbers are given from below.
    next_number = max(int(number) for number in os.listdir(f"/proc/{process.child.pid}/fd")) + 1
    resource.prlimit(process.child.pid, resource.RLIMIT_NOFILE, (next_number, limit[1]))
    answers = [process.speaking()[1] for _ in range(8)]
    assert any(answer.startswith(NO_PLACE + b"the server has no file descriptor left") for answer in answers)
    resource.prlimit(process.child.pid, resource.RLIMIT_NOFILE, limit)
    assert describe(process).version
    held.close()


def test_a_silent_connection_is_closed_after_ten_seconds(serve):
    process = serve()
    silent, start = process.connect(), time.monotonic()
    silent.settimeout(60)
    assert silent.recv(1) == b""
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
