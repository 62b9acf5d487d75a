"""Calls whose work is far longer than their request lets one expect leave the server to the others."""
import threading

import grpc
import numpy as np
import pytest
from test_cancel import Replies, bodies, body, joined, matrix

from stiefel import v1 as pb
from stiefel.v1 import simulation_pb2_grpc as rpc

#: Seconds of processor time that the server may take for what should take it milliseconds.
SOON = 3.0


def connected(process):
    """A stub with a connection of its own."""
    options = [("grpc.use_local_subchannel_pool", 1), ("grpc.max_receive_message_length", -1)]
    stub = rpc.SimulationServiceStub(process.channel(options=options))
    stub.Describe(pb.DescribeRequest(), timeout=30)
    return stub


def create(stub, name, scene):
    stub.CreateSession(pb.CreateSessionRequest(session_id=name, scene=scene, view=pb.SessionView(scene=pb.SCENE_VIEW_NONE)),
                       timeout=60)


def healthy(process):
    """Waits until the server says that it serves."""
    check = process.channel(options=[("grpc.use_local_subchannel_pool", 1)]).unary_unary("/grpc.health.v1.Health/Check")
    return check(b"", timeout=60) == b"\x08\x01"


def ended(replies, method, count):
    """The ends of `count` calls of the method, when they have come."""
    def found():
        return [entry for entry in replies.lines if '"message":"rpc"' in entry[1] and f'"method":"{method}"' in entry[1]]
    with replies.news:
        assert replies.news.wait_for(lambda: len(found()) >= count, 60), replies.lines
        return found()


#: Steps that the table of weights takes for microseconds, and that take seconds and more.
LONG = {
    "gauss4": body(8, step=1e10, name="gauss4"),
    "gauss4, N = 3": body(3, step=1e12, name="gauss4"),
    "implicit_midpoint": body(5, step=1e10, name="implicit_midpoint"),
    "variational": body(8, step=50, name="variational", order=8, substeps=20),
    "adaptive": body(8, step=1e4, name="adaptive", tolerance=1e-12),
}


@pytest.mark.parametrize("name, method", [*((name, "Step") for name in LONG), ("gauss4", "Drive")])
def test_long_steps_do_not_make_the_server_deaf(serve, name, method):
    process = serve("--log-format", "json", "--log-level", "debug", "--threads", "2")
    replies = Replies(process)
    others = connected(process)
    create(others, "long", LONG[name])
    create(others, "short", body(3, name="rk4"))
    callers = [connected(process) for _ in range(8)]
    calls = []
    for caller in callers:
        if method == "Step":
            calls.append(caller.Step.future(pb.StepRequest(session_id="long", to=1, fields=["M"]), timeout=300))
        else:
            calls.append(caller.Drive(iter([pb.DriveRequest(session_id="long", to=1, fields=["M"])]), timeout=300))
            threading.Thread(target=drained, args=(calls[-1],), daemon=True).start()
    before = process.processor_seconds()
    for caller in callers:
        caller.Describe(pb.DescribeRequest(), timeout=60)  # on the connection of a long call: it is there
    assert healthy(process)
    others.Step(pb.StepRequest(session_id="short", to=100_000), timeout=60)
    assert process.processor_seconds() - before < SOON
    before = process.processor_seconds()
    for call in calls:
        call.cancel()
    ended(replies, method, len(calls) + (method == "Step"))
    assert process.processor_seconds() - before < SOON


def drained(call):
    try:
        for _ in call:
            pass
    except grpc.RpcError:
        pass


def test_lists_of_large_ensembles_leave_the_connections_alone(serve):
    process = serve("--log-level", "off", "--memory", "4G")
    stub = connected(process)
    for k in range(4):
        create(stub, f"s{k}", bodies(65536))
    view = pb.SessionView(scene=pb.SCENE_VIEW_FILLED_IN)
    before = process.processor_seconds()
    calls = [connected(process).ListSessions.future(pb.ListSessionsRequest(view=view)) for _ in range(8)]
    calls += [connected(process).GetSession.future(pb.GetSessionRequest(session_id=f"s{k}", view=view)) for k in range(4)]
    assert healthy(process)
    for call in calls:
        call.result(60)
    # Computed anew for each session and call, the warnings alone would take five seconds.
    assert process.processor_seconds() - before < SOON


@pytest.mark.parametrize("threads", ["1", "2"])
def test_an_answer_of_connect_waits_for_no_slower_pair(serve, threads):
    """The first pair takes minutes, and the answers of the others come while it is joined. Then the call is cancelled."""
    process = serve("--log-level", "off", "--threads", threads)
    request = joined(16, 1000)
    request.pairs.extend([pb.FramePair(q_0=matrix(np.eye(16)), q_t=matrix(np.eye(16)))] * 40)
    call = connected(process).Connect(request)
    answers = [next(call) for _ in range(40)]
    assert sorted(answer.pair for answer in answers) == list(range(1, 41))
    assert {answer.run_status.outcome for answer in answers} == {pb.OUTCOME_REACHED}
    call.cancel()
    with pytest.raises(grpc.RpcError):
        next(call)
    assert healthy(process)
