"""Connections and the system's limits: many, silent, broken. Whatever they do, the next client is served or told that it is not."""
import os
import re
import resource
import signal
import stat
import subprocess
import threading
import time

import grpc
import numpy as np
import pytest

import stiefel
from conftest import BODY, PREFACE, SANITIZED, SERVER, eventually
from stiefel import v1 as pb
from stiefel.v1 import simulation_pb2_grpc as rpc

GOAWAY = 7  # a type of HTTP/2's frames
no_sanitizer = pytest.mark.skipif(SANITIZED, reason="a sanitizer takes pipes, address space and stacks of its own")


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
    process = serve("--log-format", "json", listen=listen, descriptors=(128, 256))
    assert resource.prlimit(process.child.pid, resource.RLIMIT_NOFILE) == (256, 256), "the soft limit is raised"
    silent, start = [process.connect() for _ in range(300)], time.monotonic()
    assert describe(process).version
    assert process.open_descriptors() < 256 and time.monotonic() - start > 9
    for connection in silent:
        connection.close()
    assert sum(line["count"] for line in process.log() if line["message"] == "connections refused") >= 1


@no_sanitizer
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


def test_ten_thousand_connections_come_and_go(serve):
    process = serve(descriptors=(1024, 1024))
    describe(process)
    # gRPC's connections are in one set of descriptors: no thread polls one that has none.
    folder = f"/proc/{process.child.pid}/fd"
    assert sum("eventpoll" in os.readlink(f"{folder}/{each}") for each in os.listdir(folder)) == 1
    before = process.open_descriptors()
    for _ in range(100):
        some = [process.connect() for _ in range(100)]
        for connection in some[::2]:
            connection.sendall(PREFACE)
        for connection in some:
            connection.close()
    assert describe(process).version
    assert eventually(lambda: process.open_descriptors() <= before + 5)


def test_reflection_needs_no_token_and_takes_few_threads(serve):
    process, over, most, pollers, count = serve("--log-level", "off"), threading.Event(), 16, 8, 100

    def requests():
        yield b"\x3a\x01*"
        over.wait(60)
    with process.channel() as channel:
        call = channel.stream_stream("/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo")
        assert b"stiefel" in next(call(iter([b"\x3a\x01*"]), timeout=60))
        before = process.status("Threads")
        held = [call(requests(), timeout=60) for _ in range(count)]
        assert eventually(lambda: sum(one.done() for one in held) >= count - most)
        assert process.status("Threads") <= before + most + pollers
        assert {one.code() for one in held if one.done()} == {grpc.StatusCode.RESOURCE_EXHAUSTED}
        over.set()


@pytest.fixture
def path(tmp_path):
    return f"{tmp_path}/socket"


def start_in_vain(path):
    """What a second server says."""
    run = subprocess.run([SERVER, "--listen", f"unix:{path}"], capture_output=True, text=True, timeout=60)
    assert run.returncode == 1
    return run.stderr


@pytest.mark.parametrize("umask", [0o000, 0o077])
def test_a_unix_socket_is_for_its_owner_and_removed_at_the_end(serve, path, umask):
    before = os.umask(umask)
    try:
        process = serve(listen=f"unix:{path}")
    finally:
        os.umask(before)
    assert stat.S_IMODE(os.stat(path).st_mode) == 0o600
    assert process.stop() == 0 and not os.path.exists(path)


def test_a_second_server_does_not_take_a_unix_socket(serve, path):
    process = serve(listen=f"unix:{path}")
    assert f"cannot listen on unix:{path}: another server listens there" in start_in_vain(path)
    assert describe(process).version
    process.child.send_signal(signal.SIGKILL)
    process.child.wait(60)
    assert os.path.exists(path)
    second = serve(listen=f"unix:{path}")
    os.unlink(path)
    third = serve(listen=f"unix:{path}")
    assert second.stop() == 0, "which leaves the socket that is not its own any more"
    assert describe(third).version


def test_another_file_is_left_alone(path):
    with open(path, "w", encoding="ascii") as file:
        file.write("precious")
    assert "the path is a file and no socket" in start_in_vain(path)
    with open(path, encoding="ascii") as file:
        assert file.read() == "precious"


def body(N, method):
    A = np.random.default_rng(N).normal(size=(N, N)) / N
    return {"system": "rigid_body", "inertia": list(1 + np.arange(N) / N), "step": 1e-3, "method": {"name": method},
            "initial": {"Q": np.eye(N), "M": A - A.T}}


@no_sanitizer
def test_small_stacks_are_enough(serve, tmp_path):
    """`ulimit -s`: Eigen puts up to 4 MiB on the stack of a thread. The second server restores the sessions."""
    for restored in (False, True):
        process = serve("--store", str(tmp_path / "store"), stack=(128 << 10, 128 << 10))
        with stiefel.Client(process.address) as client:
            for N, method in ((256, "rk4"), (256, "variational"), (512, "rk4")):
                id = f"{method}-{N}"
                session = client.get(id) if restored else client.create(body(N, method), id=id)
                assert session.step(to=1).step == 1
        assert process.stop() == 0


@no_sanitizer
@pytest.mark.parametrize("megabytes", [60, 100, 150])
def test_without_address_space_it_says_that_it_does_not_start(megabytes):
    """`ulimit -v`: threads and memory are refused wherever the start happens to be, or it starts and ends in order."""
    def limit():
        resource.setrlimit(resource.RLIMIT_AS, (megabytes << 20, megabytes << 20))
    done = subprocess.run([SERVER, "--listen", "127.0.0.1:0", "--exit-with-parent"], stdin=subprocess.DEVNULL, text=True,
                          capture_output=True, timeout=60, preexec_fn=limit)
    if megabytes == 150 and done.stdout.startswith("listening on "):
        assert done.returncode == 0, done.stderr
        return
    assert (done.returncode, done.stdout) == (1, ""), done.stderr
    assert re.fullmatch("stiefel-server: cannot start: .*", done.stderr.splitlines()[-1]), done.stderr


def test_a_silent_drive_keeps_no_session_and_one_that_is_used_does(serve):
    process = serve("--idle-timeout", "1.5")
    with process.channel() as channel, stiefel.Client(process.address) as client:
        session, stub, requests = client.create(BODY), rpc.SimulationServiceStub(channel), []
        more = threading.Semaphore(0)

        def sent():
            while more.acquire():
                if not requests:
                    return
                yield requests.pop()
        drive = stub.Drive(sent(), timeout=120)

        def ask(to):
            requests.append(pb.DriveRequest(session_id=session.id, to=to))
            more.release()
            return next(drive)
        there = lambda: len(stub.ListSessions(pb.ListSessionsRequest()).sessions) == 1
        for to in range(1, 9):
            assert ask(to).step.sample.step == to
            assert not eventually(lambda: not there(), 0.3)
        assert eventually(lambda: not there())
        reply = ask(10)
        assert reply.error.code == grpc.StatusCode.NOT_FOUND.value[0] and session.id in reply.error.message
        more.release()
        assert list(drive) == []


@pytest.mark.parametrize("first, told", [([b"\xff\xff\xff"], "the bytes are not a DriveRequest"),
                                         ([b"\x0a\x05ab"], "the bytes are not a DriveRequest"),
                                         ([], "the first message must name a session")], ids=["no message", "cut off", "none"])
def test_a_drive_without_a_first_request_ends_with_an_error(serve, first, told):
    with serve().channel() as channel:
        drive = channel.stream_stream("/stiefel.v1.SimulationService/Drive", request_serializer=bytes,
                                      response_deserializer=bytes)
        with pytest.raises(grpc.RpcError) as refused:
            list(drive(iter(first), timeout=60))
    assert refused.value.code() == grpc.StatusCode.INVALID_ARGUMENT
    assert told in refused.value.details()
