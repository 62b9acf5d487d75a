"""SIGTERM: it says so at once, lets work finish for the grace period, and always ends."""
import contextlib
import os
import signal
import subprocess
import threading
import time
from pathlib import Path

import grpc
import numpy as np
import pytest

import stiefel
from conftest import BODY, SANITIZED, eventually
from stiefel import v1 as pb
from stiefel.v1 import simulation_pb2_grpc as rpc

FOREVER = 10**12
# grpc.health.v1.HealthCheckResponse, whose module Debian's grpcio lacks: field 1, status.
SERVING, NOT_SERVING = b"\x08\x01", b"\x08\x02"


def watch_health(channel):
    call = channel.unary_stream("/grpc.health.v1.Health/Watch", request_serializer=bytes, response_deserializer=bytes)
    return call(b"", timeout=30)


def test_health_tells_at_once(serve):
    """From then on no call is taken, and those that run go on until the grace period is over."""
    process = serve("--grace", "300")
    with process.channel() as channel, stiefel.Client(process.address) as client:
        session = client.create(BODY)
        watch = watch_health(channel)
        assert next(watch) == SERVING
        stub = rpc.SimulationServiceStub(channel)
        running = stub.Stream(pb.StreamRequest(session_id=session.id, to=FOREVER))
        next(running)
        process.child.send_signal(signal.SIGTERM)
        assert next(watch) == NOT_SERVING
        with pytest.raises(grpc.RpcError) as refused:
            stub.Step(pb.StepRequest(session_id=session.id, to=1), timeout=60)
        assert refused.value.code() == grpc.StatusCode.UNAVAILABLE
        assert "shutting down" in refused.value.details()
        next(running)
        running.cancel()
    assert process.child.wait(60) == 0


def test_running_calls_stop_after_the_grace_period(serve):
    process = serve("--grace", "0.5")
    with process.channel() as channel, stiefel.Client(process.address) as client:
        session = client.create(BODY)
        stub, replies = rpc.SimulationServiceStub(channel), []
        step = threading.Thread(target=lambda: replies.append(
            stub.Step(pb.StepRequest(session_id=session.id, to=FOREVER), timeout=60)))
        step.start()
        process.computes()
        start = time.monotonic()
        process.child.send_signal(signal.SIGTERM)
        assert process.child.wait(60) == 0
        assert 0.4 < time.monotonic() - start
        step.join()
    assert replies[0].run_status.outcome and 0 < replies[0].sample.step < FOREVER


def test_work_that_does_not_stop_does_not_hold_it_up(serve):
    """A process that is stopped and continued finds its time over: it ends all the same."""
    process = serve("--grace", "0")
    with process.channel() as channel, stiefel.Client(process.address) as client:
        N = 512
        scene = {"system": "rigid_body", "method": {"name": "variational"}, "step": 1e-6,
                 "inertia": [1 + k / N for k in range(N)],
                 "initial": {"M": [[(i - j) / N for j in range(N)] for i in range(N)]}}
        session = client.create(scene)
        stub = rpc.SimulationServiceStub(channel)
        call = stub.Diagnose.future(pb.DiagnoseRequest(session_id=session.id, invariants=["manakov"]), timeout=300)
        process.computes()
        process.child.send_signal(signal.SIGTERM)
        assert process.child.wait(60) == 0
        call.cancel()


def open_files(pid):
    """The files that the process has open."""
    for descriptor in Path(f"/proc/{pid}/fd").iterdir():
        with contextlib.suppress(OSError):
            yield descriptor.readlink()


@pytest.mark.parametrize("silence", ["unread stream", "open drive", "silent connection"])
def test_clients_that_do_nothing_do_not_hold_it_up(serve, silence):
    process = serve("--grace", "0.2")
    with process.channel() as channel, stiefel.Client(process.address) as client:
        session, stub = client.create(BODY), rpc.SimulationServiceStub(channel)
        never = threading.Event()

        def requests():
            yield pb.DriveRequest(session_id=session.id, to=1)
            never.wait()
        held = {"unread stream": lambda: stub.Stream(pb.StreamRequest(session_id=session.id, to=FOREVER)),
                "open drive": lambda: stub.Drive(requests()), "silent connection": process.connect}[silence]()
        stub.Describe(pb.DescribeRequest(), timeout=60)  # on the connection of the held call: it is there
        process.child.send_signal(signal.SIGTERM)
        try:
            assert process.child.wait(60) == 0
        finally:
            never.set()
        del held


def test_a_server_that_is_opening_its_store_ends_at_once(serve, tmp_path):
    """Sessions of many bodies take long to restore; nothing is served yet, so nothing is waited for."""
    members = 1 << (12 if SANITIZED else 16)
    velocities = np.random.default_rng(1).normal(size=(members, 3))
    scene = {"system": "rigid_body", "step": 0.01, "members": members, "method": {"name": "rk4"},
             "body": {"moments": [1, 2, 3], "angular_velocity": velocities}}
    store = ["--store", str(tmp_path / "store"), "--grace", "0.2", "--threads", "1"]
    first = serve(*store)
    with stiefel.Client(first.address) as client:
        for number in range(8):
            client.create(scene | {"step": 0.01 + 1e-3 * number})
    first.child.kill()
    first.child.wait()
    again = subprocess.Popen([os.environ["STIEFEL_SERVER"], "--listen", "127.0.0.1:0", *store], stdin=subprocess.DEVNULL,
                             stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert eventually(lambda: any(path.name == "store" for path in open_files(again.pid)))
    again.send_signal(signal.SIGTERM)
    said = again.communicate(timeout=60)
    assert again.returncode == 0, said
    assert "listening" not in said[0]
