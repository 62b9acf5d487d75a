"""Whoever cancels a call, whatever it computes, gets the server back at once; and long calls leave it to the others."""
import json
import threading
from typing import NamedTuple, Optional

import grpc
import numpy as np
import pytest
from google.protobuf.message import Message

from conftest import Process
from every_call import RPCS, STREAMS
from stiefel import v1 as pb
from stiefel.v1 import simulation_pb2_grpc as rpc

FAR = 10**6
#: Seconds of processor time for which a call has computed when it is cancelled, and for which the server may compute until
#: that call, or the next one of the session, has ended.
UNDER_WAY, SOON = 0.02, 0.3
#: The same of the largest requests, some of which take long to be read.
UNDER_WAY_OF_LARGE, SOON_OF_LARGE = 0.3, 2.0
#: The RPCs that compute nothing for long.
SHORT = {"Describe", "GetSession", "ListSessions", "DeleteSession"}
UNLIMITED = [("grpc.max_send_message_length", -1), ("grpc.max_receive_message_length", -1),
             ("grpc.use_local_subchannel_pool", 1)]

def matrix(values):
    values = np.asarray(values, float)
    return pb.Matrix(rows=values.shape[0], cols=values.shape[1], values=values.ravel())


def body(N, system="rigid_body", wide=False, step=0.05, scale=1.0, **method):
    """A body of N dimensions whose ||Omega|| is about `scale`, Lambda from 1 to 2, or to 1000."""
    random = np.random.default_rng(N)
    A = random.standard_normal((N, N)) * scale / (2 * np.sqrt(N))
    inertia = np.geomspace(1, 1000, N) if wide else np.linspace(1, 2, N)
    M = (A - A.T) * (inertia[:, None] + inertia) / 2
    scene = pb.Scene(system=system, inertia=inertia, step=step)
    scene.initial["Q"].CopyFrom(matrix(np.eye(N)))
    scene.initial["M"].CopyFrom(matrix(M))
    if method:
        scene.method.CopyFrom(pb.Method(**method))
    return scene


def brackets(N, count):
    """The bracket of tr A^T Q and tr A^T P, so many times."""
    A, none = matrix(np.random.default_rng(1).standard_normal((N, N))), matrix(np.zeros((N, N)))
    one = pb.DiracBracket(first=[pb.LinearFunction(a=A, b=none)], second=[pb.LinearFunction(a=none, b=A)])
    return [one] * count


def joined(N, restarts):
    random = np.random.default_rng(2)
    Q = np.linalg.qr(random.standard_normal((N, N)))[0]
    Q[0] *= np.sign(np.linalg.det(Q))
    return pb.ConnectRequest(inertia=np.linspace(1, 2, N), time=1, restarts=restarts,
                             pairs=[pb.FramePair(q_0=matrix(np.eye(N)), q_t=matrix(Q))])


def blocks(p, q, members=1, **method):
    """A double bracket of p x q blocks of norm 1, or an ensemble of them."""
    random, shape = np.random.default_rng(1), (members * p, q)
    scene = pb.Scene(system="double_bracket", step=0.01, inertia_u=1 + np.arange(p) / p, inertia_v=1 + np.arange(q) / q)
    if members > 1:
        scene.members = members
    for name in "QP":
        block = scene.initial[name]
        block.CopyFrom(matrix(random.standard_normal(shape) / np.sqrt(p * q)))
        block.imaginary.extend(random.standard_normal(shape).ravel() / np.sqrt(p * q))
    if method:
        scene.method.CopyFrom(pb.Method(**method))
    return scene


def bodies(count):
    scene = pb.Scene(system="rigid_body", step=0.01, members=count, method=pb.Method(name="variational"))
    scene.body.moments.extend([1, 2, 3])
    scene.body.angular_velocity.extend(np.random.default_rng(2).normal(size=3 * count))
    return scene


class Call(NamedTuple):
    """A call that takes long, of the session "s" if it has a scene."""
    method: str
    request: Message
    scene: Optional[pb.Scene] = None

    def begin(self, stub):
        if self.scene is not None:
            stub.CreateSession(pb.CreateSessionRequest(session_id="s", scene=self.scene), timeout=60)
        if self.method not in STREAMS:
            return getattr(stub, self.method).future(self.request)
        return getattr(stub, self.method)(iter([self.request]) if self.method == "Drive" else self.request)


def to_far(scene, method="Step", **fields):
    kind = {"Step": pb.StepRequest, "Diagnose": pb.DiagnoseRequest, "Drive": pb.DriveRequest}[method]
    return Call(method, kind(session_id="s", to=FAR, **fields), scene)


#: Calls of the largest N that is allowed; each of them once computed on for seconds before it looked at its token.
CALLS = {
    "Step, variational, Lambda from 1 to 1000": to_far(body(512, wide=True, name="variational"), fields=["M"]),
    "Step, implicit_midpoint of long steps": to_far(body(512, step=5, name="implicit_midpoint"), fields=["M"]),
    "Step, adaptive": to_far(body(512, step=1000, name="adaptive", tolerance=1e-12), fields=["M"]),
    "Drive, ensemble": to_far(bodies(1 << 17), "Drive", fields=["angular_velocity"]),
    "Diagnose, brackets": Call("Diagnose", pb.DiagnoseRequest(session_id="s", dirac_brackets=brackets(512, 2)),
                               body(512, system="symmetric_rigid_body", name="variational")),
    "Diagnose, manakov": Call("Diagnose", pb.DiagnoseRequest(session_id="s", invariants=["manakov"]), body(256, name="rk4")),
    "Diagnose, symplectic test": Call("Diagnose", pb.DiagnoseRequest(
        session_id="s", symplectic_test=pb.SymplecticTest(pairs=1000)), body(32, name="variational")),
    "Diagnose, a step that takes minutes": to_far(body(8, step=1e10, name="implicit_midpoint"), "Diagnose"),
    "Diagnose, double_bracket": Call("Diagnose", pb.DiagnoseRequest(session_id="s"), blocks(256, 256, name="rk4")),
    "CreateSession, double_bracket": Call("CreateSession", pb.CreateSessionRequest(session_id="s", scene=blocks(256, 256, members=6))),
    "ForkSession, ensemble": Call("ForkSession", pb.ForkSessionRequest(
        session_id="t", from_session_id="s", from_step=FAR), bodies(1 << 17)),
    "MeasureTradeoff": Call("MeasureTradeoff", pb.MeasureTradeoffRequest(scene=body(512), budget=1e16)),
    "Convert to interpolation": Call("Convert", pb.ConvertRequest(scene=body(512), to="interpolation")),
}
WITHOUT_SCENE = {"Connect": joined(16, 1000), "ConjugatePoints": pb.ConjugatePointsRequest(
    inertia=np.linspace(1, 2, 16), q=matrix(np.eye(8, 16)), qdot=matrix(np.eye(8, 16, k=8)), time=1e6)}


def ray(N):
    """A geodesic of V(N/2, N)."""
    n = N // 2
    S = np.random.default_rng(3).standard_normal((n, N)) / (2 * np.sqrt(N))
    S[:, :n] -= (S[:, :n] + S[:, :n].T) / 2
    return scene_of("stiefel", N, Q=np.eye(n, N), S=S)


def scene_of(system, N, **initial):
    scene = pb.Scene(system=system, inertia=np.linspace(1, 2, N), step=0.05)
    for block, values in initial.items():
        scene.initial[block].CopyFrom(matrix(values))
    return scene


def altered(scene, **fields):
    other = pb.Scene.FromString(scene.SerializeToString())
    other.ClearField("method")
    other.MergeFrom(pb.Scene(**fields))
    return other


def conversion(scene, system):
    """The request; parametric systems need a parameter."""
    return pb.ConvertRequest(scene=altered(scene), to=system, return_scene=True,
                             parameter=0.1 if system.startswith("parametric") else None)


def scenes(stub, N):
    """A scene of each system, the scene that it was converted from, and the system's entry of the catalogue. Where no
    conversion leads to the system, it has the blocks of a body, and 0 for others that it must have."""
    given = [body(N), ray(N), blocks(N // 2, N // 2),
             scene_of("ellipsoid", N, q=np.eye(1, N), qdot=np.eye(1, N, k=1))]
    for system in stub.Describe(pb.DescribeRequest()).systems:
        for first in given:
            try:
                yield first, first if first.system == system.name else stub.Convert(conversion(first, system.name)).scene, system
                break
            except grpc.RpcError as refusal:
                assert refusal.code() == grpc.StatusCode.INVALID_ARGUMENT, refusal
        else:
            own = altered(given[0], system=system.name)
            for block in system.blocks:
                if block.required and block.name not in own.initial:
                    own.initial[block.name].CopyFrom(matrix(np.zeros((N, N))))
            yield own, own, system


def resting(scene):
    """The tangent vector 0, as blocks."""
    blocks = list(scene.initial.values())
    shape = [1, sum(block.rows for block in blocks), blocks[0].cols]
    return pb.Tensor(data_type=pb.DATA_TYPE_FLOAT64, shape=shape, data=np.zeros(shape).tobytes())


def requests(first, scene, system, of):
    """A request of each RPC about the scene, with more work than the test has time for where the RPC has any."""
    field = next(iter(scene.initial))
    chosen = altered(scene, tolerance=1e-9, horizon=100)
    quantity = pb.Quantity(name=system.invariants[0].name, statistics=[pb.STATISTIC_DRIFT])
    return {
        "CreateSession": pb.CreateSessionRequest(session_id="chosen", scene=chosen),
        "Step": pb.StepRequest(session_id=of, to=FAR, fields=[field]),
        "Drive": pb.DriveRequest(session_id=of, to=FAR, fields=[field]),
        "Stream": pb.StreamRequest(session_id=of, to=FAR, fields=[field]),
        "Summarize": pb.SummarizeRequest(session_id=of, to=FAR, every=1, quantities=[quantity]),
        "Linearize": pb.LinearizeRequest(session_id=of, to=FAR, vectors=resting(scene), inertia=True, step=True),
        "LyapunovSpectrum": pb.LyapunovSpectrumRequest(session_id=of, to=FAR, count=4),
        "Diagnose": pb.DiagnoseRequest(session_id=of, estimate_error=pb.ERROR_ESTIMATION_ALWAYS, to=FAR),
        "ForkSession": pb.ForkSessionRequest(session_id="fork", from_session_id=of, from_step=FAR),
        "Convert": conversion(first, scene.system) if first is not scene else conversion(scene, "velocity"),
        "MeasureTradeoff": pb.MeasureTradeoffRequest(scene=altered(scene), budget=1e16),
    }


class Replies:
    """The calls that the server has finished, by its log."""

    def __init__(self, process):
        self.lines, self.news = [], threading.Condition()
        threading.Thread(target=self.read, args=(process.child.stderr,), daemon=True).start()

    def read(self, stderr):
        for line in stderr:
            with self.news:
                self.lines.append(line)
                self.news.notify_all()

    def of(self, method, seconds, count=1):
        """The lines of the ends of the method's calls, when there are so many; no more after `seconds`."""
        def found():
            return [line for line in self.lines if '"message":"rpc"' in line and f'"method":"{method}"' in line]
        with self.news:
            self.news.wait_for(lambda: len(found()) >= count, seconds)
            return found()


def drain(call):
    try:
        for _ in call:
            pass
    except grpc.RpcError:
        pass


class Cancelled:
    """A server, and what became of the calls that were cancelled while it computed."""

    def __init__(self, serve):
        self.process = serve("--log-format", "json", "--log-level", "debug", "--threads", "2")
        self.replies = Replies(self.process)
        self.stub = rpc.SimulationServiceStub(self.process.channel(options=UNLIMITED))

    def call(self, call, under_way=UNDER_WAY):
        """The code of the call, and the seconds of processor time from its cancel to its end on the server."""
        self.replies.lines.clear()
        running = call.begin(self.stub)
        begin = self.process.processor_seconds()
        if call.method in STREAMS:
            threading.Thread(target=drain, args=(running,), daemon=True).start()
        while self.process.processor_seconds() < begin + under_way and not self.replies.of(call.method, 0.002):
            pass
        before = self.process.processor_seconds()
        running.cancel()
        end = self.replies.of(call.method, 120)
        computed = self.process.processor_seconds() - before
        assert end, f"{call.method} computes on"
        return json.loads(end[-1])["code"], computed

    def sessions(self, scene, system, most):
        """For each method that the system takes at this N, so many at most, its name, while there is a session "s" with it."""
        for on in system.methods:
            if most == 0:
                return
            of_method = altered(scene, method=pb.Method(name=on.method) if on.method else None)
            try:
                self.stub.CreateSession(pb.CreateSessionRequest(session_id="s", scene=of_method))
            except grpc.RpcError as refusal:
                assert refusal.code() == grpc.StatusCode.INVALID_ARGUMENT, refusal
                continue
            yield on.method
            self.stub.DeleteSession(pb.DeleteSessionRequest(session_id="s"))
            most -= 1

    def every_call(self, N, methods=1, under_way=UNDER_WAY):
        """System, method, RPC, code and processor seconds of every call about a scene of a system, with so many of its methods."""
        for first, scene, system in scenes(self.stub, N):
            for method in self.sessions(scene, system, methods):
                for name, request in requests(first, scene, system, "s").items():
                    yield system.name, method, name, *self.call(Call(name, request), under_way)
        for name, request in WITHOUT_SCENE.items():
            yield "", "", name, *self.call(Call(name, request), under_way)


@pytest.mark.parametrize("name", CALLS)
def test_a_cancelled_call_ends_soon(serve, name):
    code, computed = Cancelled(serve).call(CALLS[name], UNDER_WAY_OF_LARGE)
    assert code == "CANCELLED" and computed < SOON_OF_LARGE


def test_every_rpc_on_every_system_is_cancelled(serve):
    server = Cancelled(serve)
    calls, described = list(server.every_call(300)), server.stub.Describe(pb.DescribeRequest())
    cancelled = [call for call in calls if call[3] == "CANCELLED"]
    assert [call for call in cancelled if call[4] > SOON] == []
    assert {name for _, _, name, _, _ in cancelled} == set(RPCS) - SHORT
    assert {system for system, *_ in cancelled} == {"", *(system.name for system in described.systems)}


def connected(process):
    """A stub with a connection of its own."""
    stub = rpc.SimulationServiceStub(process.channel(options=UNLIMITED))
    stub.Describe(pb.DescribeRequest(), timeout=60)
    return stub


@pytest.mark.parametrize("method, scene", [
    ("Step", body(5, step=1e10, name="implicit_midpoint")), ("Drive", body(5, step=1e10, name="implicit_midpoint")),
    ("Step", body(8, step=1e4, name="adaptive", tolerance=1e-12))])
def test_steps_that_take_minutes_leave_the_server_to_the_others(serve, method, scene):
    server = Cancelled(serve)
    long, short = to_far(scene, method, fields=["M"]), pb.CreateSessionRequest(session_id="short", scene=body(3, name="rk4"))
    server.stub.CreateSession(short, timeout=60)
    callers = [connected(server.process) for _ in range(8)]
    calls = [long.begin(caller) for caller in callers]
    for call in calls if method == "Drive" else []:
        threading.Thread(target=drain, args=(call,), daemon=True).start()
    before = server.process.processor_seconds()
    for caller in callers:
        caller.Describe(pb.DescribeRequest(), timeout=60)  # on the connection of a long call: it is there
    check = server.process.channel(options=UNLIMITED).unary_unary("/grpc.health.v1.Health/Check")
    assert check(b"", timeout=60) == b"\x08\x01"
    server.stub.Step(pb.StepRequest(session_id="short", to=100_000), timeout=60)
    assert server.process.processor_seconds() - before < SOON_OF_LARGE
    before = server.process.processor_seconds()
    for call in calls:
        call.cancel()
    assert len(server.replies.of(method, 60, len(calls) + (method == "Step"))) == len(calls) + (method == "Step")
    assert server.process.processor_seconds() - before < SOON_OF_LARGE


@pytest.mark.parametrize("threads", ["1", "2"])
def test_an_answer_of_connect_waits_for_no_slower_pair(serve, threads):
    """The first pair takes minutes, and the answers of the others come while it is joined. Then the call is cancelled."""
    request = joined(16, 1000)
    request.pairs.extend([pb.FramePair(q_0=matrix(np.eye(16)), q_t=matrix(np.eye(16)))] * 40)
    call = connected(serve("--log-level", "off", "--threads", threads)).Connect(request)
    answers = [next(call) for _ in range(40)]
    assert sorted(answer.pair for answer in answers) == list(range(1, 41))
    assert {answer.run_status.outcome for answer in answers} == {pb.OUTCOME_REACHED}
    call.cancel()
    with pytest.raises(grpc.RpcError):
        next(call)


def main():
    """Prints the milliseconds of every call: test_cancel.py N [METHODS [MILLISECONDS BEFORE THE CANCEL]]."""
    import sys

    N, methods, under_way = int(sys.argv[1]), int((*sys.argv, 1)[2]), float((*sys.argv, 1, 20)[3]) / 1000
    for system, method, name, code, seconds in Cancelled(Process).every_call(N, methods, under_way):
        print(f"{system:26} {method:18} {name:16} {1000 * seconds:7.1f}  {code}", flush=True)


if __name__ == "__main__":
    main()
