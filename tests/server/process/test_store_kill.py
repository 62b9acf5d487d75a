"""A server with --store that is killed at any moment: the next one has all that was acknowledged, bit for bit."""
import os
import random
import signal
import subprocess
import threading
import time
import uuid

import grpc

from conftest import Process
from stiefel import v1 as pb
from stiefel.v1 import simulation_pb2_grpc as rpc
from stored import blocks, is_deleted, scene_of

CYCLES = int(os.environ.get("STIEFEL_KILL_CYCLES", "20"))
FULL = pb.SessionView(scene=pb.SCENE_VIEW_FULL)
SERVER = os.environ["STIEFEL_SERVER"]


def lasting(session):
    """What GetSession must answer after a restart: all but the caches and the time that is left."""
    kept = pb.Session()
    kept.CopyFrom(session)
    for field in ("cached_steps", "cursor", "expire_time"):
        kept.ClearField(field)
    return kept.SerializeToString(deterministic=True)


class Caller(threading.Thread):
    """Creates, forks and deletes sessions until the server is gone, and notes what it was told."""

    def __init__(self, address, there, seed):
        super().__init__()
        self.address, self.random = address, random.Random(seed)
        self.there, self.gone, self.unanswered = there, set(), None

    def run(self):
        with grpc.insecure_channel(self.address) as channel:
            stub = rpc.SimulationServiceStub(channel)
            try:
                while True:
                    self.call(stub)
            except grpc.RpcError:
                pass

    def call(self, stub):
        id, which = str(uuid.uuid4()), self.random.random()
        old = self.random.choice(list(self.there)) if self.there else None
        if which < 0.3 and old:
            self.unanswered = old
            del self.there[old]
            stub.DeleteSession(pb.DeleteSessionRequest(session_id=old), timeout=60)
            self.gone.add(old)
        elif which < 0.5 and old:
            self.unanswered = id
            request = pb.ForkSessionRequest(session_id=id, from_session_id=old, from_step=self.random.randrange(50), view=FULL)
            self.there[id] = lasting(stub.ForkSession(request, timeout=60).session)
        else:
            self.unanswered = id
            request = pb.CreateSessionRequest(session_id=id, scene=scene_of(self.random.randrange(10**6)), view=FULL)
            self.there[id] = lasting(stub.CreateSession(request, timeout=60).session)
        self.unanswered = None


def sessions_of(stub):
    found, token = {}, ""
    while True:
        page = stub.ListSessions(pb.ListSessionsRequest(page_size=1000, page_token=token, view=FULL), timeout=60)
        found |= {session.session_id: lasting(session) for session in page.sessions}
        token = page.next_page_token
        if not token:
            return found


def verify(found, callers):
    """Every acknowledged session is there with its bits, no deleted one is; a call without an answer did it or not."""
    there = {id: session for caller in callers for id, session in caller.there.items()}
    gone = {id for caller in callers for id in caller.gone}
    open_ = {caller.unanswered for caller in callers}
    assert not there.keys() - found.keys(), "lost"
    assert all(found[id] == session for id, session in there.items()), "other bits"
    assert not gone & found.keys(), "deleted and back"
    assert found.keys() <= there.keys() | open_, "never created"


def test_nothing_acknowledged_is_lost_when_it_is_killed(tmp_path):
    """Kills at random moments, of the start too, over and over on one store."""
    store, draw, callers, expected, deleted = str(tmp_path / "store"), random.Random(1), [], {}, 0
    for cycle in range(CYCLES):
        process = Process("--store", store, "--log-level", "warn")
        try:
            with process.channel() as channel:
                stub = rpc.SimulationServiceStub(channel)
                found = sessions_of(stub)
                verify(found, callers)
                assert all(is_deleted(stub, id) for caller in callers for id in caller.gone), "may come back"
                for id, bits in expected.items():
                    assert id not in found or blocks(stub, id, 20) == bits
                items = list(found.items())
                expected = {id: blocks(stub, id, 20) for id, _ in draw.sample(items, min(5, len(items)))}
                callers = [Caller(process.address, dict(items[k::4]), 1000 * cycle + k) for k in range(4)]
                for caller in callers:
                    caller.start()
                time.sleep(draw.uniform(0, 0.3))
                process.child.send_signal(signal.SIGKILL)
                for caller in callers:
                    caller.join()
                deleted += sum(len(caller.gone) for caller in callers)
        finally:
            process.stop()
        if cycle % 4 == 0:  # killed while it starts
            starting = subprocess.Popen([SERVER, "--listen", "127.0.0.1:0", "--store", store],
                                        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            time.sleep(draw.uniform(0, 0.08))
            starting.kill()
            starting.wait()
    assert len(found) > CYCLES and deleted > CYCLES


def test_killed_while_it_makes_its_store(tmp_path):
    """The next server finds a whole store or none."""
    for k in range(12):
        store = str(tmp_path / f"store{k}")
        starting = subprocess.Popen([SERVER, "--listen", "127.0.0.1:0", "--store", store],
                                    stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        time.sleep(0.004 * k)
        starting.kill()
        starting.wait()
        assert Process("--store", store).stop() == 0
