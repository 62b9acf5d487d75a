"""The file of --store: on a full disk, beside a second server, from a backup; and a server that is killed at any moment:
the next one has all that was acknowledged, bit for bit."""
import os
import random
import signal
import sqlite3
import subprocess
import threading
import time
import uuid

import grpc
import numpy as np
import pytest

import stiefel
from conftest import BODY, SERVER, Process, eventually, program, reason, refused_at_the_start
from stiefel import v1 as pb
from stiefel.v1 import simulation_pb2_grpc as rpc

CYCLES = int(os.environ.get("STIEFEL_KILL_CYCLES", "20"))


def scene_of(number, n=12):
    """A motion for each number; one in eight has n dimensions, so that its row has many pages."""
    if number % 8:
        return stiefel.to_message(BODY | {"step": 0.01 + 1e-6 * number})
    M = np.random.default_rng(number).uniform(-1, 1, (n, n))
    return stiefel.to_message({"system": "rigid_body", "inertia": np.linspace(1, 2, n), "step": 0.01,
                               "method": {"name": "variational"},
                               "initial": {"Q": np.eye(n), "M": M - M.T}})


def blocks(stub, id, step):
    reply = stub.Step(pb.StepRequest(session_id=id, to=step), timeout=60)
    return [field.value.data for field in reply.sample.fields]


def is_deleted(stub, id):
    """Whether a handle that has lost the session is told that it may not create it again."""
    request = pb.CreateSessionRequest(session_id=id, scene=scene_of(1), recreate=True)
    try:
        stub.CreateSession(request, timeout=60)
    except grpc.RpcError as error:
        return reason(error) == "SESSION_DELETED"
    return False


@pytest.fixture
def small_disk(tmp_path):
    """A file system of 5 MB; without the right to mount one there is no test."""
    folder = tmp_path / "disk"
    folder.mkdir()
    if subprocess.run(["mount", "-t", "tmpfs", "-o", "size=5m", "none", folder], capture_output=True).returncode != 0:
        pytest.skip("mounting a tmpfs needs root")
    yield folder
    subprocess.run(["umount", "-l", folder], check=True)


def left_on(folder):
    room = os.statvfs(folder)
    return room.f_bavail * room.f_frsize


def create(client, id, number=1, n=3):
    """Creates a session of 16n² bytes or, for n = 3, 300, without the client's retries; returns the reason of a refusal."""
    scene = scene_of(number if n == 3 else 8 * number, n)
    try:
        client._stub.CreateSession(pb.CreateSessionRequest(session_id=id, scene=scene), timeout=60)
    except grpc.RpcError as error:
        return reason(error)
    return None


def create_until_refused(client, most, n, name):
    """The names of those that were created, and the reason of the refusal."""
    made = []
    for number in range(1, most + 1):
        if refusal := create(client, f"{name}{number}", number, n):
            return made, refusal
        made.append(f"{name}{number}")
    return made, None


@pytest.mark.parametrize("n", [3, 150])
def test_a_full_disk_is_a_typed_error_that_loses_nothing_and_space_that_comes_back_is_used(serve, small_disk, n):
    """On a full disk changes end with STORE_FULL, deletions too, and all other calls work."""
    (small_disk / "rest").write_bytes(b"x" * 2_000_000)
    process = serve("--store", str(small_disk / "store"), "--log-level", "warn", "--max-sessions", "100000")
    with stiefel.Client(process.address) as client:
        made, refusal = create_until_refused(client, 20_000, n, "s")
        assert refusal == "STORE_FULL" and len(made) >= 2
        assert n > 3 or client.get(made[0]).step(10).step == 10
        (small_disk / "rest").unlink()
        for id in made[::2]:
            client.delete(id)
        again, refusal = create_until_refused(client, len(made) // 2, n, "t")
        assert refusal is None
        there = {*made[1::2], *again}
    process.child.kill()
    process.stop()
    for _ in range(2):  # after a kill, and after an end
        process = serve("--store", str(small_disk / "store"))
        with stiefel.Client(process.address) as client:
            assert {session.id for session in client.list()} == there
        assert process.stop() == 0


@pytest.mark.parametrize("suffix", ["", "-wal"])
def test_a_server_whose_store_is_removed_acknowledges_nothing(serve, tmp_path, suffix):
    process = serve("--store", str(tmp_path / "store"), "--log-level", "warn")
    with stiefel.Client(process.address) as client, process.channel() as channel:
        check = channel.unary_unary("/grpc.health.v1.Health/Check")
        first, kept = client.create(BODY), client.create(BODY)
        assert check(b"") == b"\x08\x01"
        os.rename(tmp_path / f"store{suffix}", tmp_path / "elsewhere")
        assert create(client, "second") == "STORE_UNAVAILABLE"
        with pytest.raises(grpc.RpcError) as refusal:
            client._stub.DeleteSession(pb.DeleteSessionRequest(session_id=first.id), timeout=60)
        assert reason(refusal.value) == "STORE_UNAVAILABLE" and f"store{suffix} was removed" in refusal.value.details()
        assert kept.step(10).step == 10
        assert eventually(lambda: check(b"") == b"\x08\x02"), "not serving"
        os.rename(tmp_path / "elsewhere", tmp_path / f"store{suffix}")
        assert eventually(lambda: check(b"") == b"\x08\x01")
        assert create(client, "third") is None
    assert process.stop() == 0
    log = process.child.stderr.read()
    assert "store lost" in log and "store there again" in log and f"store{suffix} was removed" in log


def check(store):
    return program("check", "--listen", "127.0.0.1:0", "--store", str(store))


def test_a_file_that_is_no_sound_store_is_refused(tmp_path):
    """By the server, and by `check`, which makes none."""
    notes = tmp_path / "notes"
    notes.write_text("not a store\n" * 1000)
    with sqlite3.connect(tmp_path / "songs") as songs:
        songs.execute("CREATE TABLE song (title TEXT)")
    for name, rule in (("notes", "file is not a database"), ("songs", "SQLite file of another program"),
                       ("no/store", "No such file or directory")):
        assert all(rule in said for said in refused_at_the_start("--store", str(tmp_path / name)))
    assert notes.read_text() == "not a store\n" * 1000
    assert check(tmp_path / "store").returncode == 0 and not (tmp_path / "store").exists()


@pytest.mark.parametrize("there", [True, False], ids=["a store", "none yet"])
def test_check_finds_that_the_store_cannot_be_written(serve, small_disk, there):
    store = small_disk / "store"
    if there:
        process = serve("--store", str(store))
        with stiefel.Client(process.address) as client:
            client.create(BODY)
        assert process.stop() == 0
    assert check(store).returncode == 0
    rest = small_disk / "rest"
    rest.write_bytes(b"x" * left_on(small_disk))
    full = check(store)
    assert full.returncode == 1 and "there is no space: the disk has " in full.stderr
    rest.unlink()
    assert check(store).returncode == 0
    subprocess.run(["mount", "-o", "remount,ro", small_disk], check=True)
    fixed = check(store)
    assert fixed.returncode == 1 and "Read-only file system" in fixed.stderr


@pytest.mark.parametrize("way", ["backup", "VACUUM INTO"])
def test_a_backup_of_a_running_server_is_a_store(serve, tmp_path, way):
    process = serve("--store", str(tmp_path / "store"))
    with stiefel.Client(process.address) as client:
        session = client.create(scene_of(8))
        bits = session.step(30, fields="Q")["Q"].tobytes()
        live = sqlite3.connect(f"file:{tmp_path / 'store'}?mode=ro", uri=True)
        if way == "backup":
            with sqlite3.connect(tmp_path / "copy") as copy:
                live.backup(copy)
            copy.close()
        else:
            live.execute("VACUUM INTO ?", [str(tmp_path / "copy")])
        live.close()
        client.create(BODY)  # the server goes on writing
    with stiefel.Client(serve("--store", str(tmp_path / "copy")).address) as client:
        assert [one.id for one in client.list()] == [session.id]
        assert client.get(session.id).step(30, fields="Q")["Q"].tobytes() == bits


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
            request = pb.ForkSessionRequest(session_id=id, from_session_id=old, from_step=self.random.randrange(50), return_scene=True)
            self.there[id] = lasting(stub.ForkSession(request, timeout=60).session)
        else:
            self.unanswered = id
            request = pb.CreateSessionRequest(session_id=id, scene=scene_of(self.random.randrange(10**6)), return_scene=True)
            self.there[id] = lasting(stub.CreateSession(request, timeout=60).session)
        self.unanswered = None


def sessions_of(stub):
    found, token = {}, ""
    while True:
        page = stub.ListSessions(pb.ListSessionsRequest(page_size=1000, page_token=token), timeout=60)
        for one in page.sessions:
            reply = stub.GetSession(pb.GetSessionRequest(session_id=one.session_id, return_scene=True), timeout=60)
            found[one.session_id] = lasting(reply.session)
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
