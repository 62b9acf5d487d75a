"""SIGTERM: it says so at once, lets work finish for the grace period, and always ends."""
import contextlib
import signal
import subprocess
import threading
import time
from pathlib import Path

import grpc
import numpy as np
import pytest

import stiefel
from conftest import BODY, SANITIZED, SERVER, eventually
from stiefel import v1 as pb
from every_call import STREAMS, every_call
from stiefel._wire.failures import from_rpc_error, from_status
from stiefel.v1 import simulation_pb2_grpc
from test_cancel import CALLS, SHORT, UNLIMITED, WITHOUT_SCENE, Call, body

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
        stub = simulation_pb2_grpc.SimulationServiceStub(channel)
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
        stub, ended = simulation_pb2_grpc.SimulationServiceStub(channel), []
        step = threading.Thread(target=lambda: ended.append(end_of(
            stub.Step.future(pb.StepRequest(session_id=session.id, to=FOREVER), timeout=60), "Step")[0]))
        step.start()
        process.computes()
        start = time.monotonic()
        process.child.send_signal(signal.SIGTERM)
        assert process.child.wait(60) == 0
        assert 0.4 < time.monotonic() - start
        step.join()
    assert ended[0].reason == "SHUTTING_DOWN"


def far(rpc, request):
    """The call of every_call.txtpb, to a step that takes hours to reach."""
    changes = {"session_id": "s", "from_session_id": "s", "to": FOREVER, "from_step": FOREVER, "every": FOREVER // 10,
               "checkpoint_every": FOREVER // 10, "return_checkpoint": True}
    for name, value in changes.items():
        if hasattr(request, name) and not (rpc == "ForkSession" and name == "session_id"):
            setattr(request, name, value)
    return Call(rpc, request, REQUESTS["CreateSession"][0].scene)


REQUESTS = dict(every_call())
OF_SESSIONS = {rpc for rpc, requests in REQUESTS.items() if {"session_id", "from_session_id"} & {
    field.name for field in requests[0].DESCRIPTOR.fields}} - SHORT - {"CreateSession"}
LONG = {rpc: far(rpc, REQUESTS[rpc][0]) for rpc in OF_SESSIONS}
LONG |= {rpc: Call(rpc, request) for rpc, request in WITHOUT_SCENE.items()}
LONG |= {call.method: call for call in (
    CALLS["CreateSession, double_bracket"], CALLS["Convert to interpolation"],
    Call("MeasureTradeoff", pb.MeasureTradeoffRequest(scene=body(24), budget=1e12)))}
#: The RPCs whose last reply has a checkpoint, and those whose error has one.
IN_REPLY, IN_ERROR = {"Stream", "Summarize", "LyapunovSpectrum"}, {"Step", "Drive", "Diagnose", "ForkSession"}


def end_of(call, rpc):
    """The error with which a call ended, and its last reply; a Drive has its error in that."""
    reply = None
    try:
        for reply in call if rpc in STREAMS else [call.result()]:
            pass
    except grpc.RpcError as failure:
        return from_rpc_error(failure), reply
    return (from_status(reply.error) if rpc == "Drive" else None), reply


@pytest.mark.parametrize("rpc", sorted(LONG))
def test_an_ended_call_says_that_the_server_ends(serve, rpc):
    """And not that its caller has cancelled it, nor what a run that was cut off had reached."""
    assert set(LONG) == set(REQUESTS) - SHORT
    process, ends = serve("--grace", "0", "--threads", "2"), []
    with process.channel(options=UNLIMITED) as channel:
        call = LONG[rpc].begin(simulation_pb2_grpc.SimulationServiceStub(channel))
        reader = threading.Thread(target=lambda: ends.append(end_of(call, rpc)))
        reader.start()
        process.computes(0.3)
        process.child.send_signal(signal.SIGTERM)
        reader.join()
        (error, reply), = ends
        assert isinstance(error, stiefel.Unavailable) and error.reason == "SHUTTING_DOWN", error
        if rpc in IN_ERROR:
            assert error._checkpoint[0] > 0 and error._checkpoint[1]
        if rpc in IN_REPLY:
            assert reply.checkpoint.data and getattr(reply.checkpoint, "step", 1) > 0
    assert process.child.wait(60) == 0


def test_work_that_stops_late_does_not_hold_it_up(serve):
    process = serve("--grace", "0")
    with process.channel(options=UNLIMITED) as channel:
        call = CALLS["Diagnose, manakov"].begin(simulation_pb2_grpc.SimulationServiceStub(channel))
        process.computes()
        process.child.send_signal(signal.SIGTERM)
        assert process.child.wait(60) == 0
        call.cancel()


@pytest.mark.parametrize("silence", ["unread stream", "open drive", "silent connection"])
def test_clients_that_do_nothing_do_not_hold_it_up(serve, silence):
    process = serve("--grace", "0.2")
    with process.channel() as channel, stiefel.Client(process.address) as client:
        session, stub = client.create(BODY), simulation_pb2_grpc.SimulationServiceStub(channel)
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
    again = subprocess.Popen([SERVER, "--listen", "127.0.0.1:0", *store], stdin=subprocess.DEVNULL,
                             stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)

    def opened():
        with contextlib.suppress(OSError):  # of a descriptor that is closed meanwhile
            return any(path.readlink().name == "store" for path in Path(f"/proc/{again.pid}/fd").iterdir())
    assert eventually(opened)
    again.send_signal(signal.SIGTERM)
    said = again.communicate(timeout=60)
    assert again.returncode == 0, said
    assert "listening" not in said[0]
