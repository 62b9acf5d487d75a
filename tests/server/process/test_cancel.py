"""Whoever cancels a long call of a large scene gets the server back at once, whatever it computes."""
import json
import signal
import threading
import time

import grpc
import numpy as np
import pytest

from every_call import STREAMS, every_call
from stiefel import v1 as pb
from stiefel.v1 import simulation_pb2_grpc as rpc

#: Seconds of processor time, of two threads, that the server may take from the cancel to its reply; it takes 0.05 to 0.3.
SOON = 2.0
#: Seconds of the server's processor time after which a call is under way; a large request takes some to be read.
UNDER_WAY, UNDER_WAY_OF_LARGE = 0.3, 1.5


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


def chosen(N):
    scene = body(N)
    scene.tolerance, scene.horizon = 1e-9, 100.0
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


def with_session(scene, call):
    """`call(stub, id)` once a session of the scene exists."""
    def start(stub):
        stub.CreateSession(pb.CreateSessionRequest(session_id="s", scene=scene), timeout=60)
        return call(stub, "s")
    return start


def blocks(p, q, **method):
    """A double bracket of p x q blocks of norm 1."""
    random = np.random.default_rng(1)
    scene = pb.Scene(system="double_bracket", step=0.01, inertia_u=1 + np.arange(p) / p, inertia_v=1 + np.arange(q) / q)
    for name in "QP":
        block = scene.initial[name]
        block.CopyFrom(matrix(random.standard_normal((p, q)) / np.sqrt(p * q)))
        block.imaginary.extend(random.standard_normal(p * q) / np.sqrt(p * q))
    if method:
        scene.method.CopyFrom(pb.Method(**method))
    return scene


def bodies(count):
    scene = pb.Scene(system="rigid_body", step=0.01, members=count, method=pb.Method(name="variational"))
    scene.body.moments.extend([1, 2, 3])
    scene.body.angular_velocity.extend(np.random.default_rng(2).normal(size=3 * count))
    return scene


def step_of(scene):
    return with_session(scene, lambda stub, s: stub.Step.future(pb.StepRequest(
        session_id=s, to=10**6, fields=["M"])))


def diagnosis_of(scene, **asked):
    return with_session(scene, lambda stub, s: stub.Diagnose.future(pb.DiagnoseRequest(session_id=s, **asked)))


def linearized(N, method="variational"):
    """One vector of a body whose state has too many numbers for coordinates."""
    M = np.zeros((1, 2 * N, N))
    M[0, N, 1], M[0, N + 1, 0] = 1, -1
    vectors = pb.Tensor(data_type=pb.DATA_TYPE_FLOAT64, shape=M.shape, data=M.tobytes())
    return with_session(body(N, name=method), lambda stub, s: stub.Linearize(pb.LinearizeRequest(
        session_id=s, to=10**6, vectors=vectors)))


def stream_of(method, request):
    return lambda stub: getattr(stub, method)(request)


def drive_of(scene, field="M"):
    return with_session(scene, lambda stub, s: stub.Drive(iter([pb.DriveRequest(
        session_id=s, to=10**6, fields=[field])])))


#: The largest N that is allowed, 512, wherever that does not refuse the call.
CALLS = {
    "CreateSession, choice": lambda stub: stub.CreateSession.future(
        pb.CreateSessionRequest(session_id="s", scene=chosen(48))),
    "Step, rk4": step_of(body(512, name="rk4")),
    "Step, variational": step_of(body(512, name="variational")),
    "Step, variational of order 8, substeps": step_of(body(512, name="variational", order=8, substeps=1000)),
    "Step, variational, Lambda from 1 to 1000": step_of(body(512, wide=True, name="variational")),
    "Step, munthe_kaas4": step_of(body(512, name="munthe_kaas4")),
    "Step, implicit_midpoint": step_of(body(512, name="implicit_midpoint")),
    "Step, gauss4": step_of(body(512, name="gauss4")),
    "Step, gauss4 of long steps": step_of(body(512, step=5, name="gauss4")),
    "Step, adaptive": step_of(body(512, step=1000, name="adaptive", tolerance=1e-12)),
    "Step, moser_veselov": step_of(body(512, system="moser_veselov")),
    "Stream": with_session(body(512, name="munthe_kaas4"),
                           lambda stub, s: stub.Stream(pb.StreamRequest(session_id=s, to=10**6))),
    "Drive": drive_of(body(512, name="munthe_kaas4")),
    "ForkSession": with_session(
        body(512, name="rk4"), lambda stub, s: stub.ForkSession.future(pb.ForkSessionRequest(
            session_id="t", from_session_id=s, from_step=10**6))),
    "Diagnose, manakov": diagnosis_of(body(256, name="rk4"), invariants=["manakov"]),
    "Diagnose, estimate": diagnosis_of(body(24, name="rk4"), to=100, estimate_error=pb.ERROR_ESTIMATION_ALWAYS),
    "Diagnose, symplectic test": diagnosis_of(body(32, name="variational"), symplectic_test=pb.SymplecticTest(pairs=1000)),
    "Diagnose, a step that takes minutes": diagnosis_of(body(8, step=1e10, name="gauss4")),
    "Diagnose, double_bracket": diagnosis_of(blocks(256, 256, name="rk4")),
    "CreateSession, double_bracket": lambda stub: stub.CreateSession.future(
        pb.CreateSessionRequest(session_id="s", scene=blocks(256, 256))),
    "ForkSession, ensemble": with_session(bodies(65536), lambda stub, s: stub.ForkSession.future(pb.ForkSessionRequest(
        session_id="t", from_session_id=s, from_step=10**6))),
    "Drive, ensemble": drive_of(bodies(65536), "angular_velocity"),
    "Summarize, ensemble": with_session(bodies(65536), lambda stub, s: stub.Summarize(pb.SummarizeRequest(
        session_id=s, to=10**6, every=10**5, quantities=[pb.Quantity(name="energy", statistics=[pb.STATISTIC_DRIFT])]))),
    "Linearize": with_session(body(24, name="variational"), lambda stub, s: stub.Linearize(pb.LinearizeRequest(
        session_id=s, to=10**6))),
    "Linearize, N = 300": linearized(300),
    "Linearize, N = 300, munthe_kaas4": linearized(300, "munthe_kaas4"),
    "LyapunovSpectrum, N = 300": with_session(body(300, name="variational"), lambda stub, s: stub.LyapunovSpectrum(
        pb.LyapunovSpectrumRequest(session_id=s, to=10**6, count=4))),
    "LyapunovSpectrum": with_session(body(24, name="variational"), lambda stub, s: stub.LyapunovSpectrum(
        pb.LyapunovSpectrumRequest(session_id=s, to=10**6, count=4))),
    "Diagnose, brackets": diagnosis_of(body(512, system="symmetric_rigid_body", name="variational"),
                                       dirac_brackets=brackets(512, 2)),
    "MeasureTradeoff": stream_of("MeasureTradeoff", pb.MeasureTradeoffRequest(scene=body(512), budget=1e16)),
    "MeasureTradeoff, runs": stream_of("MeasureTradeoff", pb.MeasureTradeoffRequest(scene=body(24), budget=1e12)),
    "Connect": stream_of("Connect", joined(16, 1000)),
    "ConjugatePoints": stream_of("ConjugatePoints", pb.ConjugatePointsRequest(
        inertia=np.linspace(1, 2, 16), q=matrix(np.eye(8, 16)), qdot=matrix(np.eye(8, 16, k=8)), time=1e6)),
    "Convert to interpolation": stream_of("Convert", pb.ConvertRequest(scene=body(512), to="interpolation")),
    "Convert to parametric_rigid_body": stream_of(
        "Convert", pb.ConvertRequest(scene=body(512), to="parametric_rigid_body", parameter=0.1)),
}

#: Those that `make test` has; each of them computed on for seconds before it looked at its token.
QUICK = ["Step, variational, Lambda from 1 to 1000", "Diagnose, brackets", "Diagnose, a step that takes minutes",
         "Diagnose, double_bracket", "CreateSession, double_bracket", "ForkSession, ensemble", "MeasureTradeoff", "Connect",
         "ConjugatePoints", "Convert to interpolation", "Linearize, N = 300", "LyapunovSpectrum, N = 300"]


def rpc_of(name):
    return name.split(",")[0].split()[0]


#: The RPCs that compute nothing for long; CALLS has all others.
SHORT = {"Describe", "GetSession", "ListSessions", "DeleteSession"}


def far(rpc, request):
    """The call of every_call.txtpb, to a step that takes hours to reach."""
    request.session_id, request.to = "s", 10**12
    return with_session(REQUESTS["CreateSession"][0].scene,
                        lambda stub, s: (getattr(stub, rpc) if rpc in STREAMS else getattr(stub, rpc).future)(request))


REQUESTS = dict(every_call())
FAR = {rpc: far(rpc, requests[0]) for rpc, requests in REQUESTS.items()
         if rpc not in set(map(rpc_of, CALLS)) and hasattr(requests[0], "to")}
CALLS |= FAR
QUICK += FAR


class Replies:
    """When the server finished the calls of a method, by its log."""

    def __init__(self, process):
        self.lines, self.news = [], threading.Condition()
        threading.Thread(target=self.read, args=(process.child.stderr,), daemon=True).start()

    def read(self, stderr):
        for line in stderr:
            with self.news:
                self.lines.append((time.monotonic(), line))
                self.news.notify_all()

    def of(self, method, seconds):
        """The time and the line of the method's end; None if it does not come."""
        def found():
            return next((entry for entry in self.lines if '"message":"rpc"' in entry[1] and f'"method":"{method}"' in entry[1]),
                        None)
        with self.news:
            self.news.wait_for(found, seconds)
            return found()


def start(process, name):
    """Starts the call, waits until the server computes, and gives the call with its channel."""
    channel = process.channel(options=[("grpc.max_send_message_length", -1), ("grpc.max_receive_message_length", -1)])
    call = CALLS[name](rpc.SimulationServiceStub(channel))
    if rpc_of(name) in STREAMS:
        threading.Thread(target=drain, args=(call,), daemon=True).start()
    process.computes(UNDER_WAY_OF_LARGE if "brackets" in name else UNDER_WAY)
    return channel, call


def drain(call):
    try:
        for _ in call:
            pass
    except grpc.RpcError:
        pass


def cancelled(serve, name, patience=60.0):
    """From the cancel to the end of the call on the server: seconds, those of processor time, and how it ended."""
    process = serve("--log-format", "json", "--log-level", "debug", "--threads", "2")
    replies = Replies(process)
    channel, call = start(process, name)
    method = rpc_of(name)
    assert replies.of(method, 0) is None, "the call ended before it was cancelled"
    begin, before = time.monotonic(), process.processor_seconds()
    call.cancel()
    end = replies.of(method, patience)
    computed = process.processor_seconds() - before
    channel.close()
    return (end[0] - begin, computed, json.loads(end[1])["code"]) if end else (patience, computed, "none")


def test_every_rpc_that_computes_is_cancelled():
    assert {rpc_of(name) for name in CALLS} == set(REQUESTS) - SHORT


@pytest.mark.parametrize("name", QUICK)
def test_a_cancelled_call_ends_soon(serve, name):
    _, computed, code = cancelled(serve, name)
    assert code == "CANCELLED"
    assert computed < SOON


def test_sigterm_ends_a_server_that_computes(serve):
    process = serve("--grace", "0.3")
    channel, _ = start(process, "MeasureTradeoff")
    process.child.send_signal(signal.SIGTERM)
    assert process.child.wait(60) == 0
    channel.close()


def main():
    """Prints the time of every call, for README and docs: python3 tests/server/process/test_cancel.py [NAME ...]."""
    import sys
    from pathlib import Path

    sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
    from conftest import Process
    started = []

    def serve(*arguments):
        started.append(Process(*arguments))
        return started[-1]
    for name in sys.argv[1:] or CALLS:
        try:
            seconds, _, code = cancelled(serve, name, 25)
            print(f"{name:45} {1000 * seconds:8.0f} ms  {code}", flush=True)
        except (AssertionError, grpc.RpcError) as fault:
            print(f"{name:45} {fault}", flush=True)
        started[-1].child.kill()


if __name__ == "__main__":
    main()
