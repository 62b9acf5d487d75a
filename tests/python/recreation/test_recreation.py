"""A handle creates its session again where its server has lost it, and only that handle does."""
import threading
import time

import grpc
import numpy as np
import pytest

import stiefel
from stiefel._wire import failures, held, recreating, retries

BODY = {"system": "rigid_body", "step": 0.01, "body": {"moments": [1, 2, 3], "angular_velocity": [0.1, 1, 0.2]},
        "method": {"name": "preprocessed_variational"}}


class Replaceable:
    """A server that loses its sessions whenever it is replaced, at one address."""

    def __init__(self, folder):
        self.address = f"unix:{folder}/server"
        self.server = None
        self.replace()

    def replace(self):
        self.stop()
        self.server = stiefel.Server.start(listen=self.address, arguments=["--grace", "0"])

    def stop(self):
        if self.server:
            self.server.process.kill()
            self.server.process.wait()
            self.server.stop()
        self.server = None


@pytest.fixture
def place(tmp_path):
    place = Replaceable(tmp_path)
    yield place
    place.stop()


@pytest.fixture
def client(place):
    with stiefel.Client(place.address) as client:
        yield client


def find(client, seconds=20):
    """Waits until the client has found the server again; on a busy machine its retries may end before."""
    end = time.monotonic() + seconds
    while True:
        try:
            return client.describe()
        except stiefel.Unavailable:
            assert time.monotonic() < end


def same(one, other):
    return one.step == other.step and one.keys() == other.keys() and all(np.array_equal(one[k], other[k]) for k in one)


def test_every_call_goes_on_at_a_server_that_lost_the_session(place, client):
    session = client.create(BODY)
    expected, drive = session.step(300), session.drive()
    assert same(drive.step(300), expected)
    drift = session.diagnose(300).invariants[0].drift
    fork = session.fork(300, step=0.02)
    forked = fork.step(10)
    place.replace()
    assert same(session.step(300), expected)
    place.replace()
    assert same(drive.step(300), expected)
    place.replace()
    assert session.diagnose(300).invariants[0].drift == drift
    place.replace()
    assert same(session.fork(300, step=0.02).step(10), forked)
    place.replace()
    assert same(fork.step(10), forked), "whose parent is not there"
    place.replace()
    last, = session.stream(to=300, start=300)
    assert all(np.array_equal(last[field][0], expected[field]) for field in expected)


def wide(N=370):
    """A scene whose blocks are too large for a reply."""
    A = np.random.default_rng(1).normal(size=(N, N)) / N
    return {"system": "rigid_body", "step": 0.01, "inertia": np.linspace(1, 2, N), "method": {"name": "rk4"},
            "initial": {"Q": np.eye(N), "M": A - A.T}}


def test_a_fork_that_is_lost_before_its_scene_has_arrived_is_made_again(place, client, monkeypatch):
    session = client.create(wide())
    expected, fetch, lost = session.fork(1).step(2), held.scene_arrays, []

    def fetch_late(*arguments):
        if not lost:
            lost.append(place.replace())
        return fetch(*arguments)
    monkeypatch.setattr(held, "scene_arrays", fetch_late)
    fork = session.fork(1)
    assert lost and same(fork.step(2), expected)
    place.replace()
    assert same(fork.step(2), expected), "whose parent is not there"


def test_a_stream_goes_on_where_it_broke(place, client):
    session = client.create(BODY)
    whole, parts = session.trajectory(to=20_000), []
    for batch in session.stream(to=20_000):
        parts.append(batch)
        if len(parts) in (1, 5):
            place.replace()
    assert np.array_equal(np.concatenate([batch.step for batch in parts]), whole.step)
    assert np.array_equal(np.concatenate([batch["quaternion"] for batch in parts]), whole["quaternion"])


def test_it_goes_on_from_the_last_checkpoint(place, client):
    session = client.create(BODY)
    checkpoint = session.step(5000, checkpoint=True).checkpoint
    place.replace()
    assert session.step(5001).computed_steps == 1
    other = client.create(BODY, checkpoint=checkpoint)
    place.replace()
    assert other.step(5002).computed_steps == 2, "with which it was created"


def test_it_goes_back_from_an_earlier_checkpoint(place, client):
    """A call that goes back after the loss does not begin at step 0."""
    checkpoint = client.create(BODY).step(5000, checkpoint=True).checkpoint
    session = client.create(BODY, checkpoint=checkpoint)
    for lost in range(2):
        session.step(7000, checkpoint=True)
        place.replace()
        assert session.step(5002).computed_steps == 2, "from the one that it was created with"
        assert session.step(7001).computed_steps == 1, "from the last one"
    other = client.create(BODY)
    for step in (9000, 8000, 9500):
        other.step(step, checkpoint=True)
    place.replace()
    with other.drive() as drive:
        assert drive.step(8003).computed_steps == 3 and drive.step(9501).computed_steps == 1


def test_a_checkpoint_near_by_is_not_asked_for_again(client):
    session = client.create(BODY, checkpoint=client.create(BODY).step(10**6, checkpoint=True).checkpoint)
    handle, every = session._recreation, session._recreation.checkpoint_every()
    assert not any(handle.wants_checkpoint(to) for to in (0, every - 1, 10**6, 10**6 + every - 1))
    assert handle.wants_checkpoint(10**6 + every) and (every > 10**6 or handle.wants_checkpoint(every))


def test_checkpoints_come_by_themselves_about_every_second_of_work(place, client, monkeypatch):
    session = client.create(BODY)
    monkeypatch.setattr(recreating, "WORK_BETWEEN_CHECKPOINTS", 1000 * session.step_price.work)
    assert session.step(999).checkpoint == b"" and not session._recreation.has_checkpoint
    assert session.step(1000).checkpoint == b"", "which nobody asked for"
    place.replace()
    assert session.step(1001).computed_steps == 1
    with session.drive() as drive:
        assert drive.step(3000).checkpoint == b""
    place.replace()
    assert session.step(3001).computed_steps == 1
    list(session.stream(to=10_500, start=10_000, every=500))
    place.replace()
    assert session.step(10_500).computed_steps < 1500, "a checkpoint comes with the next sample"
    list(session.stream(to=50_000, start=11_000, every=39_000))
    place.replace()
    assert session.step(50_000).computed_steps <= 1000, "between two samples"


def test_only_the_handle_that_created_it_creates_it_again(place, client):
    session = client.create(BODY)
    found, listed = client.get(session.id), next(client.list())
    place.replace()
    find(client)
    for handle in (found, listed):
        with pytest.raises(stiefel.NotFound) as caught:
            handle.step(1)
        assert caught.value.reason == "SESSION_NOT_FOUND"
    with pytest.raises(stiefel.NotFound):
        list(found.stream(to=3))
    assert list(client.list()) == []
    assert session.step(1).step == 1 and found.step(1).step == 1


def test_a_deleted_session_stays_deleted(place, client):
    session = client.create(BODY)
    drive = session.drive()
    drive.step(1)
    with stiefel.Client(place.address) as other:
        other.delete(session.id)
    for call in (lambda: session.step(1), lambda: drive.step(1), lambda: session.fork(1), lambda: session.diagnose(1),
                 lambda: session.trajectory(to=3)):
        with pytest.raises(stiefel.NotFound, match="was deleted") as caught:
            call()
        assert caught.value.reason == "SESSION_DELETED"
    assert list(client.list()) == []


def test_a_handle_that_deleted_its_session_makes_no_call(place, client):
    session = client.create(BODY, id="mine")
    drive = session.drive()
    drive.step(1)
    session.delete()
    client.create(BODY, id="mine")
    for call in (lambda: session.step(1), lambda: drive.step(1), lambda: session.trajectory(to=3)):
        with pytest.raises(stiefel.NotFound) as caught:
            call()
        assert caught.value.reason == "SESSION_DELETED"
    session.delete()
    assert list(client.list()) == []


def test_a_deletion_during_a_recreation_wins(place, client):
    session = client.create(BODY)
    place.replace()
    send, created = session._recreation._send, threading.Event()

    def late(method, request, deadline):
        reply = send(method, request, deadline)
        if method == "CreateSession":
            created.set()
            session._recreation.end()  # as `delete` begins
        return reply
    session._recreation._send = late
    with pytest.raises(stiefel.NotFound):
        session.step(1)
    assert created.is_set() and list(client.list()) == []


def test_without_a_server_it_ends(place):
    with stiefel.Client(place.address, timeout=2) as client:
        session = client.create(BODY)
        place.stop()
        for call in (lambda: session.step(1), lambda: session.trajectory(to=10), lambda: session.drive().step(1),
                     lambda: session.step(1, timeout=0.1), client.describe):
            with pytest.raises((stiefel.Unavailable, stiefel.DeadlineExceeded)):
                call()


def test_a_server_that_comes_back_after_seconds_is_waited_for(place, client):
    session = client.create(BODY)
    expected = session.step(300)
    place.stop()
    threading.Timer(4, place.replace).start()
    assert same(session.step(300), expected)


@pytest.mark.parametrize("call", [
    lambda s, to: s.step(to), lambda s, to: s.drive().step(to), lambda s, to: s.diagnose(to), lambda s, to: s.fork(to).step(0),
    lambda s, to: s.trajectory(to=to, every=to), lambda s, to: s.summarize(to, {"quaternion": "last"}, checkpoint_every=to),
], ids=["step", "drive", "diagnose", "fork", "trajectory", "summarize"])
def test_a_call_goes_on_where_a_server_ended(place, client, call):
    """SIGTERM lets a call lose less than SIGKILL: the server sends where it stood, and the next one goes on from there."""
    to = 1_500_000
    session, kept, answers = client.create(BODY), [], []
    keep = session._recreation.keep
    session._recreation.keep = lambda step, checkpoint: (kept.append(step), keep(step, checkpoint))
    caller = threading.Thread(target=lambda: answers.append(call(session, to)))
    caller.start()
    computing(place.server.process.pid)
    place.server.process.terminate()
    place.server.process.wait()
    place.replace()
    caller.join()
    whole = call(client.create(BODY), to)
    answer, = answers
    if isinstance(whole, stiefel.State):
        assert same(answer, whole)
    elif isinstance(whole, stiefel.Trajectory):
        assert np.array_equal(answer["quaternion"], whole["quaternion"])
    elif isinstance(whole, stiefel.Diagnosis):
        assert answer.invariants == whole.invariants
    else:
        assert np.array_equal(answer["quaternion"]["last"], whole["quaternion"]["last"])
    if not isinstance(whole, stiefel.Summary):  # whose checkpoint is its own
        assert 0 < kept[0] < to


def computing(pid):
    """Waits until a process has computed for 0.1 s, from now on."""
    def ticks():
        return int(open(f"/proc/{pid}/stat", encoding="ascii").read().rpartition(")")[2].split()[11])
    before = ticks()
    while ticks() < before + 10:
        time.sleep(0.01)


@pytest.mark.parametrize("id", ["no name", "line\nbreak", "ü", "x" * 129, ""])
def test_a_name_that_no_server_takes_is_not_routed(client, id):
    with pytest.raises(stiefel.InvalidArgument, match="session_id"):
        client.get(id)


def failed(code, says):
    """The exception for a call that gRPC ended."""
    class Failure(grpc.RpcError):
        def code(self): return code
        def details(self): return says
        def trailing_metadata(self): return ()
    return failures.from_rpc_error(Failure())


@pytest.mark.parametrize("code, says, taken", [
    (grpc.StatusCode.CANCELLED, "Received RST_STREAM with error code 8", True),
    (grpc.StatusCode.UNKNOWN, "Stream removed", True),
    (grpc.StatusCode.CANCELLED, "CANCELLED", True),
    (grpc.StatusCode.CANCELLED, "Locally cancelled by application!", False),
    (grpc.StatusCode.RESOURCE_EXHAUSTED, "Received RST_STREAM with error code 11", False),
])
def test_a_connection_that_broke_is_unavailable(code, says, taken):
    assert isinstance(failed(code, says), stiefel.Unavailable) == taken


@pytest.mark.parametrize("says, tried", [("Received RST_STREAM with error code 11", [0.05, 0.1, 0.2, 0.4, 0.8, None]),
                                         ("received initial metadata size exceeds limit", [None])])
def test_too_much_at_once_is_tried_again(says, tried):
    pauses = retries.Pauses()
    assert [pauses.after(failed(grpc.StatusCode.RESOURCE_EXHAUSTED, says)) for _ in tried] == tried
