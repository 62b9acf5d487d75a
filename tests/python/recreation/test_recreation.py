"""A handle creates its session again where its server has lost it, and only that handle does."""
import threading
import time

import numpy as np
import pytest

import fake
import stiefel
from stiefel import v1 as pb
from stiefel._wire import calls

BODY = {"system": "rigid_body", "step": 0.01, "body": {"moments": [1, 2, 3], "angular_velocity": [0.1, 1, 0.2]},
        "method": {"name": "preprocessed_variational"}}


class Replaceable:
    """A server that loses its sessions whenever it is replaced, at one address."""

    def __init__(self, folder):
        self.address, self.server = f"unix:{folder}/server", None
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


CALLS = {
    "step": lambda s, to: s.step(to)["quaternion"], "drive": lambda s, to: s.drive().step(to)["quaternion"],
    "trajectory": lambda s, to: s.trajectory(to=to)["quaternion"],
    "stream": lambda s, to: np.concatenate([batch["quaternion"] for batch in s.stream(to=to)]),
    "times": lambda s, to: s.trajectory(times=[0.005, to * 0.01])["quaternion"],
    "summarize": lambda s, to: s.summarize(to, quantities={"quaternion": ["last", "mean"]}, checkpoint_every=to // 7)["quaternion"]["mean"],
    "events": lambda s, to: s.events(to, events={"field": "angular_velocity", "coefficients": [1, 0, 0]}).time,
    "lyapunov": lambda s, to: s.lyapunov(to).exponents,
    "linearize": lambda s, to: s.linearize(to).matrix,
    "diagnose": lambda s, to: np.array([one.drift for one in s.diagnose(to).invariants]),
    "fork": lambda s, to: s.fork(to, step=0.02).step(10)["quaternion"],
}


@pytest.mark.parametrize("call", CALLS)
def test_a_call_has_the_same_bits_at_a_server_that_lost_the_session(place, client, call):
    session, drive = client.create(BODY), client.create(BODY).drive()
    expected, driven = CALLS[call](client.create(BODY), 3000), drive.step(2)
    place.replace()
    assert CALLS[call](session, 3000).tobytes() == expected.tobytes()
    assert drive.step(2) == driven, "a drive that was open goes on too"


@pytest.mark.parametrize("call, to", [("step", 10**6), ("drive", 10**6), ("trajectory", 10**6), ("diagnose", 10**6), ("summarize", 10**6),
                                      ("lyapunov", 300_000), ("linearize", 10**6)])
def test_a_rolling_update_is_survived(place, client, call, to):
    """SIGTERM ends the server while it computes, and a new one listens at the same address."""
    expected, session, answers = CALLS[call](client.create(BODY), to), client.create(BODY), []
    caller = threading.Thread(target=lambda: answers.append(CALLS[call](session, to)))
    caller.start()
    computing(place.server.process.pid)
    place.server.process.terminate()
    place.server.process.wait()
    assert not answers
    place.replace()
    caller.join()
    assert answers[0].tobytes() == expected.tobytes()


def computing(pid):
    """Waits until a process has computed for 0.05 s, from now on."""
    def ticks():
        return int(open(f"/proc/{pid}/stat", encoding="ascii").read().rpartition(")")[2].split()[11])
    before = ticks()
    while ticks() < before + 5:
        time.sleep(0.002)


def test_it_goes_on_from_the_last_checkpoint(place, client, monkeypatch):
    """From one that the caller asked for, and from those that come by themselves after about a second of work."""
    session = client.create(BODY)
    monkeypatch.setattr(calls, "WORK_BETWEEN_CHECKPOINTS", 6000 * session.step_price.work)
    checkpoint = session.step(5000, checkpoint=True).checkpoint
    other = client.create(BODY, checkpoint=checkpoint)
    place.replace()
    assert session.step(5001).computed_steps == 1
    assert other.step(5002).computed_steps <= 2, "with which it was created"
    far = 2 * session._calls.checkpoint_every()
    assert session.step(far).checkpoint == b"", "which nobody asked for"
    place.replace()
    assert session.step(far + 1).computed_steps == 1
    monkeypatch.setattr(calls, "SHARED_WORK", session.step_price.work)
    assert session._calls.checkpoint_every() == 8 * 6000


def test_only_the_handle_that_created_it_creates_it_again(place, client):
    session = client.create(BODY)
    found, listed = client.get(session.id), next(client.list())
    place.replace()
    for handle in (found, listed):
        with pytest.raises(stiefel.NotFound) as caught:
            handle.step(1)
        assert caught.value.reason == "SESSION_NOT_FOUND"
    assert list(client.list()) == []
    assert session.step(1).step == 1 and found.step(1).step == 1


def test_a_deleted_session_stays_deleted(place, client):
    """By another client, by this handle, and before a recreation."""
    session, own, late = client.create(BODY), client.create(BODY, id="mine"), client.create(BODY)
    drive = session.drive()
    drive.step(1)
    with stiefel.Client(place.address) as other:
        other.delete(session.id)
    own.delete()
    client.create(BODY, id="mine").delete()
    for call in (lambda: session.step(1), lambda: drive.step(1), lambda: session.fork(1), lambda: session.trajectory(to=3),
                 lambda: own.step(1), lambda: own.drive().step(1)):
        with pytest.raises(stiefel.NotFound, match="was deleted") as caught:
            call()
        assert caught.value.reason == "SESSION_DELETED"
    place.replace()
    late._calls.is_lost(stiefel.NotFound("", (), "SESSION_NOT_FOUND", {"session_id": late.id}))
    client.delete(late.id)  # before the handle creates it again
    with pytest.raises(stiefel.NotFound, match="was deleted"):
        late.step(1)
    assert list(client.list()) == []


class OtherBuild(fake.Fake):
    """The fake with the numerics id "other"."""

    def _receive(self, request, context):
        context.send_initial_metadata((("stiefel-numerics-id", "other"),))
        super()._receive(request, context)


def test_another_build_is_gone_on_at_only_on_request(tmp_path, monkeypatch):
    monkeypatch.setattr(fake, "Fake", OtherBuild)
    _, server, address = fake.serve(tmp_path)
    message = pb.Session(session_id="fake", numerics_id="mine", scene=pb.Scene(step=0.5))
    with stiefel.Client(address) as client:
        session = stiefel.Session(client._connection, message, True, owner=True)
        for call in (lambda: session.step(1), lambda: session.trajectory(to=10), lambda: session.drive().step(1)):
            with pytest.raises(stiefel.BuildChanged, match="mine.*other") as caught:
                call()
            assert (caught.value.began_with, caught.value.now, caught.value.reason) == ("mine", "other", "BUILD_CHANGED")
    with stiefel.Client(address, any_build=True) as client:
        session = stiefel.Session(client._connection, message, True, owner=True)
        assert session.step(1).step == 1 and session.trajectory(to=10).samples == 11
    server.stop(None)
