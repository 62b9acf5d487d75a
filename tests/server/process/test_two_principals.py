"""Two principals with the same ids, one of whom creates, deletes, lists and guesses: neither sees, delays or ends the other's."""
import collections
import os
import statistics
import subprocess
import threading
import time
import uuid

import grpc
import pytest

import stiefel
from conftest import BODY
from stiefel import v1 as pb
from stiefel._wire.failures import from_status
from stiefel.v1 import simulation_pb2_grpc as rpc

GUESSES = int(os.environ.get("STIEFEL_GUESSES", "2000"))
AT_ONCE = 100
ANSWERED = 10.0  # seconds, for a Step of some microseconds, on a machine of any load


def token(name):
    done = subprocess.run([os.environ["STIEFEL_SERVER"], "token", name], capture_output=True, text=True, timeout=60, check=True)
    return done.stdout.splitlines()


class Caller:
    """A principal: its stub and the metadata of its token."""

    def __init__(self, address, secret):
        self.channel = grpc.insecure_channel(address)
        self.stub, self.who = rpc.SimulationServiceStub(self.channel), (("authorization", f"Bearer {secret}"),)

    def call(self, method, request):
        return getattr(self.stub, method)(request, timeout=60, metadata=self.who)

    def begin(self, method, request):
        return getattr(self.stub, method).future(request, timeout=60, metadata=self.who)

    def create(self, id, step, recreate=False):
        scene = stiefel.to_message({**BODY, "step": step})
        return self.call("CreateSession", pb.CreateSessionRequest(session_id=id, scene=scene, recreate=recreate))

    def bits(self, id, to=50):
        reply = self.call("Step", pb.StepRequest(session_id=id, to=to))
        return [field.value.data for field in reply.sample.fields]

    def ids(self):
        return {session.session_id for session in
                self.call("ListSessions", pb.ListSessionsRequest(page_size=1000)).sessions}


@pytest.fixture
def principals(serve, tmp_path):
    (alices, her_line), (bobs, his_line) = token("alice"), token("bob")
    (tmp_path / "tokens").write_text(f"{her_line}\n{his_line}\n")
    process = serve("--tokens", str(tmp_path / "tokens"), "--log-level", "off", "--max-sessions", "100000")
    alice, bob = Caller(process.address, alices), Caller(process.address, bobs)
    yield alice, bob
    alice.channel.close()
    bob.channel.close()


def refusal(call):
    """What the call is refused with; none if it is not."""
    try:
        call()
    except grpc.RpcError as error:
        return from_status(pb.Status.FromString(dict(error.trailing_metadata())["grpc-status-details-bin"]))
    return None


class Steps(threading.Thread):
    """Single Steps of a principal, one after another: the seconds that each took, or what went wrong."""

    def __init__(self, caller, id):
        super().__init__()
        self.caller, self.id, self.over = caller, id, threading.Event()
        self.seconds, self.error, self.expected = [], None, caller.bits(id)

    def run(self):
        try:
            while not self.over.is_set():
                begin = time.monotonic()
                assert self.caller.bits(self.id) == self.expected
                self.seconds.append(time.monotonic() - begin)
                time.sleep(0.002)
        except BaseException as error:  # noqa: B036 - told by the test's own thread
            self.error = error

    def stop(self):
        self.over.set()
        self.join()
        assert self.error is None, self.error
        return self.seconds


def guesses(ids):
    """(method, request) of ids that are another's or nobody's, half of each."""
    for k in range(GUESSES):
        id = ids[k % len(ids)] if k % 2 else str(uuid.uuid4())
        yield [("GetSession", pb.GetSessionRequest(session_id=id)), ("Step", pb.StepRequest(session_id=id, to=3)),
               ("Diagnose", pb.DiagnoseRequest(session_id=id, to=3)),
               ("ForkSession", pb.ForkSessionRequest(session_id=f"fork-{k}", from_session_id=id))][k // 2 % 4], id


def told(call, id):
    """What a refusal says, without the id."""
    error = call.exception(60)
    assert isinstance(error, grpc.RpcError), f"{id} was found"
    details = dict(error.trailing_metadata())["grpc-status-details-bin"]
    return error.code(), error.details().replace(id, "ID"), details.replace(id.encode(), b"ID")


def guess_all(bob, ids):
    """Guesses with `AT_ONCE` under way; what was told, by method and whether the id was another's."""
    seen, under_way = collections.defaultdict(set), collections.deque()

    def take():
        call, method, id = under_way.popleft()
        seen[method, id in hers].add(told(call, id))
    hers = set(ids)
    for (method, request), id in guesses(ids):
        under_way.append((bob.begin(method, request), method, id))
        if len(under_way) == AT_ONCE:
            take()
    while under_way:
        take()
    return seen


def test_neither_sees_delays_or_ends_the_others(principals):
    alice, bob = principals
    ids = [str(uuid.uuid4()) for _ in range(50)]
    for k, id in enumerate(ids):
        alice.create(id, 0.01 + 1e-5 * k)
    expected = {id: alice.bits(id) for id in ids}
    stream = alice.stub.Stream(pb.StreamRequest(session_id=ids[0], to=10**12, every=10**6), metadata=alice.who)
    next(stream)
    before = Steps(alice, ids[1])
    before.start()
    time.sleep(0.5)
    alone = before.stop()

    during = Steps(alice, ids[1])
    during.start()
    try:
        seen = guess_all(bob, ids)
        for method in ("GetSession", "Step", "Diagnose", "ForkSession"):
            assert seen[method, True] == seen[method, False], "what is another's is as if it were nobody's"
            (code, _, _), = seen[method, True]
            assert code == grpc.StatusCode.NOT_FOUND
        assert bob.ids() == set()
        same = ids[:20]
        for round in range(GUESSES // 1000):  # sessions of the same ids with another motion, and their end
            made = [bob.begin("CreateSession", pb.CreateSessionRequest(
                session_id=id, scene=stiefel.to_message({**BODY, "step": 0.5}))) for id in same]
            assert all(call.result(60).created for call in made), round
            assert bob.ids() == set(same)
            assert bob.bits(same[1]) != expected[same[1]]
            gone = [bob.begin("DeleteSession", pb.DeleteSessionRequest(session_id=id)) for id in ids]
            assert all(call.result(60) is not None for call in gone)
            assert bob.ids() == set()
    finally:
        crowded = during.stop()
    print(f"{GUESSES} guesses; median of a Step: alone {1e3 * statistics.median(alone):.2f} ms, meanwhile "
          f"{1e3 * statistics.median(crowded):.2f} ms, longest {1e3 * max(crowded):.1f} ms of {len(crowded)}")
    assert len(crowded) > 10 and max(crowded) < ANSWERED

    assert alice.ids() == set(ids)
    assert {id: alice.bits(id) for id in ids} == expected
    assert next(stream).steps, "her stream goes on"
    stream.cancel()
    # What he deleted is not deleted for her, and the other way round.
    alice.call("DeleteSession", pb.DeleteSessionRequest(session_id=ids[-1]))
    assert not alice.create(ids[0], 0.01, recreate=True).created
    assert alice.create("new", 0.01, recreate=True).created
    assert bob.call("DeleteSession", pb.DeleteSessionRequest(session_id="other")) is not None
    assert alice.create("other", 0.01, recreate=True).created
    with pytest.raises(grpc.RpcError) as refused:
        alice.create(ids[-1], 0.01, recreate=True)
    assert refused.value.code() == grpc.StatusCode.NOT_FOUND
    assert bob.create("new", 0.01).created
