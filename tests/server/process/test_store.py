"""A server with --store: killed at any moment, on a full disk, beside another one, from a backup."""
import os
import random
import resource
import shutil
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
from conftest import BODY, Process, eventually
from stiefel import v1 as pb
from stiefel.v1 import simulation_pb2_grpc as rpc

CYCLES = int(os.environ.get("STIEFEL_KILL_CYCLES", "20"))
FULL = pb.SessionView(scene=pb.SCENE_VIEW_FULL, checksum=True)
SERVER = os.environ["STIEFEL_SERVER"]


def scene_of(number, n=12):
    """A motion for each number; one in eight has n dimensions, so that its row has many pages."""
    if number % 8:
        return stiefel.to_message(BODY | {"step": 0.01 + 1e-6 * number})
    M = np.random.default_rng(number).uniform(-1, 1, (n, n))
    return stiefel.to_message({"system": "rigid_body", "inertia": np.linspace(1, 2, n), "step": 0.01,
                               "method": {"name": "variational"},
                               "initial": {"Q": np.eye(n), "M": M - M.T}})


def lasting(session):
    """What GetSession must answer after a restart: all but the caches and the time that is left."""
    kept = pb.Session()
    kept.CopyFrom(session)
    for field in ("cached_steps", "cursor", "expire_time"):
        kept.ClearField(field)
    return kept.SerializeToString(deterministic=True)


def blocks(stub, id, step):
    reply = stub.Step(pb.StepRequest(session_id=id, to=step), timeout=20)
    return [field.value.data for field in reply.sample.fields]


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
            stub.DeleteSession(pb.DeleteSessionRequest(session_id=old), timeout=20)
            self.gone.add(old)
        elif which < 0.5 and old:
            self.unanswered = id
            request = pb.ForkSessionRequest(session_id=id, from_session_id=old, from_step=self.random.randrange(50), view=FULL)
            self.there[id] = lasting(stub.ForkSession(request, timeout=20).session)
        else:
            self.unanswered = id
            request = pb.CreateSessionRequest(session_id=id, scene=scene_of(self.random.randrange(10**6)), view=FULL)
            self.there[id] = lasting(stub.CreateSession(request, timeout=20).session)
        self.unanswered = None


def sessions_of(stub):
    found, token = {}, ""
    while True:
        page = stub.ListSessions(pb.ListSessionsRequest(page_size=1000, page_token=token, view=FULL), timeout=60)
        found |= {session.session_id: lasting(session) for session in page.sessions}
        token = page.next_page_token
        if not token:
            return found


def reason(error):
    status, info = pb.Status.FromString(dict(error.trailing_metadata())["grpc-status-details-bin"]), pb.ErrorInfo()
    info.ParseFromString(status.details[0].value)
    return info.reason


def is_deleted(stub, id):
    """Whether a handle that has lost the session is told that it may not create it again."""
    request = pb.CreateSessionRequest(session_id=id, scene=scene_of(1), recreate=True)
    try:
        stub.CreateSession(request, timeout=20)
    except grpc.RpcError as error:
        return reason(error) == "SESSION_DELETED"
    return False


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


def fill(client):
    """Creates sessions of 10 KB until one is refused; returns those that were not, and the error."""
    made = {}
    for number in range(8, 8000, 8):
        try:
            session = client.create(scene_of(number, n=24), id=f"s{number}")
        except stiefel.StiefelError as error:
            return made, error
        made[session.id] = session
    raise AssertionError("nothing was refused")


def test_a_full_disk_is_a_typed_error_and_loses_nothing(serve, small_disk):
    process = serve("--store", str(small_disk / "store"), "--log-level", "warn")
    with stiefel.Client(process.address) as client:
        made, error = fill(client)
        assert isinstance(error, stiefel.ResourceExhausted) and error.reason == "STORE_FULL"
        assert "no space in the store" in str(error)
        assert len(made) > 20
        some = next(iter(made))
        assert client.get(some).step(10).step == 10
    process.child.kill()
    process.stop()
    process = serve("--store", str(small_disk / "store"), "--log-level", "warn")
    with stiefel.Client(process.address) as client:
        assert {session.id for session in client.list()} == made.keys()
    assert process.stop() == 0
    process = serve("--store", str(small_disk / "store"), "--log-level", "warn")
    with stiefel.Client(process.address) as client:
        assert {session.id for session in client.list()} == made.keys()
        (small_disk / "rest").write_bytes(b"x" * left_on(small_disk))
        for id in list(made)[:20]:
            client.delete(id)
        (small_disk / "rest").unlink()
        client.create(BODY)


def test_a_file_that_may_not_grow_is_a_full_disk(serve, tmp_path):
    """RLIMIT_FSIZE, set on the running server and lifted again."""
    process = serve("--store", str(tmp_path / "store"), "--log-level", "warn")
    with stiefel.Client(process.address) as client:
        client.create(scene_of(8), id="first")
        before = resource.prlimit(process.child.pid, resource.RLIMIT_FSIZE)
        resource.prlimit(process.child.pid, resource.RLIMIT_FSIZE, (100_000, before[1]))
        _, error = fill(client)
        assert isinstance(error, stiefel.ResourceExhausted) and error.reason == "STORE_FULL"
        resource.prlimit(process.child.pid, resource.RLIMIT_FSIZE, before)
        client.create(scene_of(16), id="last")
        known = {session.id for session in client.list()}
    process.child.kill()
    process.stop()
    with stiefel.Client(serve("--store", str(tmp_path / "store")).address) as client:
        assert {session.id for session in client.list()} == known >= {"first", "last"}


def refused(*arguments):
    """The line on stderr of a server that does not start."""
    done = subprocess.run([SERVER, "--listen", "127.0.0.1:0", *arguments], stdin=subprocess.DEVNULL,
                          capture_output=True, text=True, timeout=30)
    assert done.returncode == 1 and done.stdout == ""
    return done.stderr


def test_a_second_server_is_refused(serve, tmp_path):
    store = str(tmp_path / "store")
    first = serve("--store", store)
    assert f"the store {store}: in use by process {first.child.pid}" in refused("--store", store)
    first.child.kill()
    first.child.wait()
    serve("--store", store)


def test_a_file_that_is_no_sound_store_is_refused(tmp_path):
    notes = tmp_path / "notes"
    notes.write_text("not a store\n" * 1000)
    assert "it is not an SQLite database" in refused("--store", str(notes))
    assert notes.read_text() == "not a store\n" * 1000
    with sqlite3.connect(tmp_path / "songs") as songs:
        songs.execute("CREATE TABLE song (title TEXT)")
    assert "SQLite file of another program" in refused("--store", str(tmp_path / "songs"))
    assert "No such file or directory" in refused("--store", str(tmp_path / "no" / "store"))


def test_a_torn_store_is_refused_or_whole(serve, tmp_path):
    whole = tmp_path / "store"
    process = serve("--store", str(whole))
    with stiefel.Client(process.address) as client:
        ids = {client.create(scene_of(number)).id for number in range(0, 200, 8)}
    assert process.stop() == 0  # the log is in the file now
    draw, size, refusals = random.Random(1), whole.stat().st_size, 0
    for k in range(8):
        torn = tmp_path / f"torn{k}"
        shutil.copy(whole, torn)
        os.truncate(torn, draw.randrange(size))
        done = subprocess.Popen([SERVER, "--listen", "127.0.0.1:0", "--exit-with-parent", "--store", str(torn)],
                                stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        line = done.stdout.readline()
        if line:
            with stiefel.Client(line.split()[-1]) as client:
                assert {session.id for session in client.list()} == ids
            done.communicate()
        else:
            assert f"the store {torn}" in done.communicate()[1]
            refusals += 1
    assert refusals > 0


def test_check_looks_at_the_store(tmp_path):
    def check(store):
        return subprocess.run([SERVER, "check", "--listen", "127.0.0.1:0", "--store", str(store)],
                              capture_output=True, text=True, timeout=30)
    assert check(tmp_path / "store").returncode == 0
    assert not (tmp_path / "store").exists()
    (tmp_path / "notes").write_text("not a store\n" * 1000)
    assert check(tmp_path / "notes").returncode == 1
    assert "--store: the store" in check(tmp_path / "notes").stderr


@pytest.mark.parametrize("way", ["backup", "VACUUM INTO"])
def test_a_backup_of_a_running_server_is_a_store(serve, tmp_path, way):
    process = serve("--store", str(tmp_path / "store"))
    with stiefel.Client(process.address) as client:
        session = client.create(scene_of(8))
        bits = session.step(30).fields["Q"].tobytes()
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
        assert client.get(session.id).step(30).fields["Q"].tobytes() == bits


def test_a_handle_does_not_bring_back_what_was_deleted_before_the_server_was_killed(serve, tmp_path):
    process = serve("--store", str(tmp_path / "store"))
    with stiefel.Client(process.address) as one, stiefel.Client(process.address) as other:
        handle, kept = one.create(scene_of(1)), one.create(scene_of(2))
        other.delete(handle.id)
        process.child.kill()
        process.stop()
        serve("--store", str(tmp_path / "store"), listen=process.address)
        with pytest.raises(stiefel.StiefelError) as refused:
            handle.step(10)
        assert refused.value.reason == "SESSION_DELETED"
        assert kept.step(10).step == 10
        assert [session.id for session in other.list()] == [kept.id]


def test_a_tombstone_ends_when_its_time_is_over(serve, tmp_path):
    store = str(tmp_path / "store")
    process = serve("--store", store, "--idle-timeout", "0.5")
    with process.channel() as channel:
        rpc.SimulationServiceStub(channel).DeleteSession(pb.DeleteSessionRequest(session_id="a"), timeout=20)
    process.child.kill()
    process.stop()
    time.sleep(0.5)
    process = serve("--store", store)
    with process.channel() as channel:
        assert not is_deleted(rpc.SimulationServiceStub(channel), "a")
    with sqlite3.connect(f"file:{store}?mode=ro", uri=True) as live:
        assert live.execute("SELECT count(*) FROM tombstone").fetchone() == (0,)


def test_restored_sessions_take_their_principals_seats(serve, tmp_path):
    store = ("--store", str(tmp_path / "store"))
    process = serve(*store)
    with stiefel.Client(process.address) as client:
        ids = [client.create(scene_of(number)).id for number in range(3)]
    process.child.kill()
    process.stop()
    process = serve(*store, "--principal-sessions", "3")
    with process.channel() as channel:
        stub = rpc.SimulationServiceStub(channel)
        more = pb.CreateSessionRequest(session_id="more", scene=scene_of(3))
        with pytest.raises(grpc.RpcError) as refused:
            stub.CreateSession(more, timeout=20)
        assert refused.value.code() == grpc.StatusCode.RESOURCE_EXHAUSTED and reason(refused.value) == "OVER_QUOTA"
        stub.DeleteSession(pb.DeleteSessionRequest(session_id=ids[0]), timeout=20)
        assert stub.CreateSession(more, timeout=20).created


def test_idle_sessions_leave_the_store(serve, tmp_path):
    process = serve("--store", str(tmp_path / "store"), "--idle-timeout", "0.2")
    with stiefel.Client(process.address) as client:
        client.create(BODY)
        assert eventually(lambda: not list(client.list()))
    process.child.kill()
    process.stop()
    with stiefel.Client(serve("--store", str(tmp_path / "store")).address) as client:
        assert not list(client.list())


def test_checkpoints_are_written_behind(serve, tmp_path):
    """A killed server's successor goes on near the step that was reached."""
    process = serve("--store", str(tmp_path / "store"))
    with process.channel() as channel:
        stub = rpc.SimulationServiceStub(channel)
        stub.CreateSession(pb.CreateSessionRequest(session_id="a", scene=scene_of(1)), timeout=20)
        bits = blocks(stub, "a", 500_000)

        def stored():
            with sqlite3.connect(f"file:{tmp_path / 'store'}?mode=ro", uri=True) as live:
                return live.execute("SELECT step FROM checkpoint").fetchone()
        assert eventually(stored)
    process.child.kill()
    process.stop()
    process = serve("--store", str(tmp_path / "store"))
    with process.channel() as channel:
        reply = rpc.SimulationServiceStub(channel).Step(pb.StepRequest(session_id="a", to=500_000), timeout=20)
        assert [field.value.data for field in reply.sample.fields] == bits
        assert reply.computed_steps < 500_000
