"""Everything that takes memory of a server, at once: sessions of large bodies, ensembles, streams that nobody reads,
messages at the limit, forged checkpoints, compressed requests. `flood` says how the calls ended."""
import threading
import time
from collections import Counter
from concurrent.futures import ThreadPoolExecutor

import grpc
import numpy as np

from stiefel import v1 as pb
from stiefel.v1 import common_pb2
from stiefel.v1 import simulation_pb2_grpc as rpc

UNLIMITED = [("grpc.max_send_message_length", -1), ("grpc.max_receive_message_length", -1)]


def tensor(array):
    array = np.ascontiguousarray(array, dtype="<f8")
    return pb.Tensor(data_type=pb.DATA_TYPE_FLOAT64, shape=array.shape, data=array.tobytes())


def body(N, method="variational"):
    A = np.random.default_rng(1).normal(size=(N, N)) / N
    scene = pb.Scene(system="rigid_body", step=1e-3, inertia=1 + np.arange(N) / N)
    scene.method.name = method
    scene.initial_tensors["Q"].CopyFrom(tensor(np.eye(N)))
    scene.initial_tensors["M"].CopyFrom(tensor(A - A.T))
    return scene


def ensemble(members):
    scene = pb.Scene(system="rigid_body", step=1e-2, members=members)
    scene.body.moments.extend([1, 2, 3])
    scene.body.angular_velocity.extend(np.random.default_rng(2).normal(size=3 * members))
    return scene


def creation(id, scene, checkpoint=b""):
    return pb.CreateSessionRequest(session_id=id, scene=scene, checkpoint=checkpoint)


def quota_of(error):
    """The subjects of a refusal's QuotaFailure."""
    for key, value in error.trailing_metadata() or ():
        if key != "grpc-status-details-bin":
            continue
        for detail in common_pb2.Status.FromString(value).details:
            if detail.type_url.endswith("google.rpc.QuotaFailure"):
                failure = common_pb2.QuotaFailure.FromString(detail.value)
                return [violation.subject for violation in failure.violations]
    return []


class Health:
    """Asks the standard health service all the time, on a connection of its own."""

    def __init__(self, process):
        self.longest, self.answers, self.wrong = 0.0, 0, []
        self._channel = process.channel()
        self._check = self._channel.unary_unary("/grpc.health.v1.Health/Check")
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._ask)

    def _ask(self):
        while not self._stop.wait(0.05):
            begin = time.monotonic()
            try:
                answer = self._check(b"", timeout=30)
            except grpc.RpcError as error:
                answer = error.code()
            self.longest = max(self.longest, time.monotonic() - begin)
            self.answers += 1
            if answer != b"\x08\x01":  # status: SERVING
                self.wrong.append(answer)

    def __enter__(self):
        self._thread.start()
        return self

    def __exit__(self, *_):
        self._stop.set()
        self._thread.join()
        self._channel.close()


class Ends:
    """How calls ended, by kind, and the refusals that do not say what was used up."""

    def __init__(self):
        self.count, self.untyped, self._lock = Counter(), [], threading.Lock()

    def add(self, kind, error=None):
        with self._lock:
            self.count[kind, error.code().name if error else "OK"] += 1
            if error and error.code() is grpc.StatusCode.RESOURCE_EXHAUSTED and not quota_of(error) \
                    and "larger" not in error.details() and "Buffers full" not in error.details():
                self.untyped.append(error.details())

    def of(self, kind):
        return {code: n for (kinds, code), n in self.count.items() if kinds == kind}

    def call(self, kind, work):
        try:
            work()
        except grpc.RpcError as error:
            self.add(kind, error)
        else:
            self.add(kind)


def flood(process, *, sessions, dimension, ensembles, members, streams, messages, at_once=8):
    """Runs all of it and returns the ends; the sessions stay."""
    ends = Ends()
    channels = [process.channel(options=[*UNLIMITED, ("channel", k)]) for k in range(4)]
    stubs = [rpc.SimulationServiceStub(channel) for channel in channels]
    largest = stubs[0].Describe(pb.DescribeRequest()).limits.max_message_bytes
    large = body(dimension)
    stubs[0].CreateSession(creation("streamed", large))

    def create(k):
        ends.call("session", lambda: stubs[k % 4].CreateSession(creation(f"s{k}", large), timeout=600))

    def create_ensemble(k):
        ends.call("ensemble", lambda: stubs[k % 4].CreateSession(creation(f"e{k}", ensemble(members)), timeout=600))

    def send_large(k):
        request = creation(f"m{k}", body(3), checkpoint=bytes(largest - 4096))
        ends.call("message", lambda: stubs[k % 4].CreateSession(request, timeout=600))

    def forge(k):
        request = creation(f"f{k}", body(3), checkpoint=np.random.default_rng(k).bytes(100_000))
        ends.call("forged", lambda: stubs[k % 4].CreateSession(request, timeout=600))

    def bomb(k):
        request = creation(f"b{k}", body(3), checkpoint=bytes(largest - 4096))
        ends.call("bomb", lambda: stubs[k % 4].CreateSession(request, timeout=600, compression=grpc.Compression.Gzip))

    unread = []

    def stream(k):
        call = stubs[k % 4].Stream(pb.StreamRequest(session_id="streamed", to=10**12, **{"from": k % 7}))
        unread.append(call)
        ends.call("stream", lambda: next(call))

    with ThreadPoolExecutor(at_once) as pool:
        jobs = [(create, sessions), (create_ensemble, ensembles), (send_large, messages), (forge, messages),
                (bomb, messages), (stream, streams)]
        done = [pool.submit(job, k) for k in range(max(n for _, n in jobs)) for job, n in jobs if k < n]
        for one in done:
            one.result()
    time.sleep(1)
    for call in unread:
        call.cancel()
    for channel in channels:
        channel.close()
    return ends
