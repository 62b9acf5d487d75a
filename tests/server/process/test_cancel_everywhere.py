"""Every RPC that computes is cancelled while it computes, on every system of the catalogue, with large matrices."""
import itertools
import json
import threading
import time

import grpc
import numpy as np

from every_call import RPCS, STREAMS
from stiefel import v1 as pb
from stiefel.v1 import simulation_pb2_grpc as rpc
from test_cancel import SHORT, Replies, blocks, body, drain, joined, matrix

FAR = 10**6
#: Seconds of processor time for which a call has computed when it is cancelled, and for which the server may compute until
#: that call, or the next one of the session, has ended.
UNDER_WAY, SOON = 0.02, 0.3


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
    return pb.ConvertRequest(scene=altered(scene), to=system, view=pb.SCENE_VIEW_FULL,
                             parameter=0.1 if system.startswith("parametric") else None)


def converted(stub, scene, system):
    replies = list(stub.Convert(conversion(scene, system)))
    scene, arrays = replies[0].scene, [field for reply in replies for field in reply.scene_arrays]
    for name, parts in itertools.groupby(arrays, lambda field: field.name):
        parts = list(parts)
        values = np.frombuffer(b"".join(part.value.data for part in parts))
        shape = list(parts[0].whole_shape or parts[0].value.shape)
        scene.initial[name.removeprefix("initial.")].CopyFrom(matrix(values.reshape(shape)))
    return scene


def scenes(stub, N):
    """A scene of each system, the scene that it was converted from, and the system's entry of the catalogue."""
    given = [body(N), ray(N), blocks(N // 2, N // 2),
             scene_of("ellipsoid", N, q=np.eye(1, N), qdot=np.eye(1, N, k=1))]
    for system in stub.Describe(pb.DescribeRequest()).systems:
        for first in given:
            try:
                yield first, first if first.system == system.name else converted(stub, first, system.name), system
                break
            except grpc.RpcError as refusal:
                assert refusal.code() == grpc.StatusCode.INVALID_ARGUMENT, refusal
        else:
            raise AssertionError(f"no scene of {system.name}")


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


def without_scene():
    return {"Connect": joined(16, 1000), "ConjugatePoints": pb.ConjugatePointsRequest(
        inertia=np.linspace(1, 2, 16), q=matrix(np.eye(8, 16)), qdot=matrix(np.eye(8, 16, k=8)), time=1e6)}


class Cancelled:
    """A server, and what became of the calls that were cancelled while it computed."""

    def __init__(self, serve):
        self.process = serve("--log-format", "json", "--log-level", "debug", "--threads", "2")
        self.replies = Replies(self.process)
        self.channel = self.process.channel(options=[("grpc.max_send_message_length", -1),
                                                     ("grpc.max_receive_message_length", -1)])
        self.stub = rpc.SimulationServiceStub(self.channel)

    def processor_seconds(self):
        """As of Process, to nanoseconds: the processor clock of another process."""
        return time.clock_gettime(~self.process.child.pid << 3 | 2)

    def call(self, method, request, under_way=UNDER_WAY):
        """The code of the call, and the seconds of processor time from its cancel to its end on the server."""
        self.replies.lines.clear()
        begin = self.processor_seconds()
        if method in STREAMS:
            call = getattr(self.stub, method)(iter([request]) if method == "Drive" else request)
            threading.Thread(target=drain, args=(call,), daemon=True).start()
        else:
            call = getattr(self.stub, method).future(request)
        while self.processor_seconds() < begin + under_way and not self.replies.of(method, 0.002):
            pass
        before = self.processor_seconds()
        call.cancel()
        end = self.replies.of(method, 120)
        computed = self.processor_seconds() - before
        assert end, f"{method} computes on"
        return json.loads(end[1])["code"], computed

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
                    yield system.name, method, name, *self.call(name, request, under_way)
        for name, request in without_scene().items():
            yield "", "", name, *self.call(name, request, under_way)


def test_every_rpc_on_every_system_is_cancelled(serve):
    calls = list(Cancelled(serve).every_call(300))
    cancelled = [call for call in calls if call[3] == "CANCELLED"]
    assert [call for call in cancelled if call[4] > SOON] == []
    assert {name for _, _, name, _, _ in cancelled} == set(RPCS) - SHORT
    assert {system for system, *_ in cancelled} == {system for system, *_ in calls}


def main():
    """Prints the milliseconds of every call: test_cancel_everywhere.py N [METHODS [MILLISECONDS BEFORE THE CANCEL]]."""
    import sys

    from conftest import Process
    N, methods, under_way = int(sys.argv[1]), int((*sys.argv, 1)[2]), float((*sys.argv, 1, 20)[3]) / 1000
    for system, method, name, code, seconds in Cancelled(Process).every_call(N, methods, under_way):
        print(f"{system:26} {method:18} {name:16} {1000 * seconds:7.1f}  {code}", flush=True)


if __name__ == "__main__":
    main()
