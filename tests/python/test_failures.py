"""Retries, resumption, deadlines and exceptions, against a server that fails on purpose."""
import re
import socket

import grpc
import numpy as np
import pytest

import fake
import stiefel
from stiefel._wire import calls
from stiefel._wire.calls import Calls
from stiefel._wire.connection import Connection

UNAVAILABLE, EXHAUSTED = grpc.StatusCode.UNAVAILABLE, grpc.StatusCode.RESOURCE_EXHAUSTED


class Clock:
    """The time as the client's deadlines see it. Only `sleep` moves it."""

    def __init__(self):
        self.now = 0.0

    def monotonic(self):
        return self.now

    def sleep(self, seconds):
        self.now += seconds


@pytest.fixture
def service(tmp_path):
    service, server, address = fake.serve(tmp_path)
    service.address = address
    yield service
    server.stop(None)


@pytest.fixture
def session(service, without_pauses):
    with stiefel.Client(service.address) as client:
        session = client.get("fake")
        session.client = client
        yield session
        service.failures.clear()


@pytest.fixture
def clock(service, monkeypatch):
    """A clock by which every message of a stream takes 30 s, and pauses as long as they are. gRPC, which measures real
    time, gets a minute more."""
    clock = Clock()
    messages = Calls.messages
    monkeypatch.setattr(Calls, "messages", lambda handle, method, request, timeout: messages(
        handle, method, request, timeout and timeout + 60))
    monkeypatch.setattr(calls, "time", clock)
    monkeypatch.setattr(Connection, "rest", lambda connection, seconds, away=False: clock.sleep(seconds))
    service.before_message = lambda: clock.sleep(30)
    return clock


def test_a_server_that_went_is_waited_for_until_the_deadline(service, clock, capsys):
    """The deadline is the client's where a call has none, and stderr is told once in an outage."""
    with stiefel.Client(service.address, timeout=40) as client:
        session, never = client.get("fake"), [UNAVAILABLE] * 1000
        for call, seconds in ((session.step, 40), (lambda to: session.step(to, timeout=90), 90), (session.trajectory, 40),
                              (session.drive().step, 40)):
            service.failures, begin = list(never), clock.now
            with pytest.raises(stiefel.Unavailable, match="on purpose"):
                call(to=5)
            assert seconds - 1 < clock.now - begin <= seconds + 1
        told = capsys.readouterr().err.splitlines()
        assert [line.partition("; ")[0] for line in told] == ["stiefel: on purpose"] * 4 and "; waits for up to 36.5 s more" in told[0]
        service.failures = list(never[:40])
        assert session.step(to=5).step == 5 and session.step(to=6).step == 6
        assert len(capsys.readouterr().err.splitlines()) == 1
        service.failures, begin = list(never), clock.now
        session.__exit__(None)
        assert clock.now - begin < 2, "the end of a block asks for nothing"


def test_what_is_not_made_again(service, session):
    """Other errors, a refusal without a time or until after the deadline; and a server that was never reached, or stays away
    from a connection that does not wait, gets six attempts."""
    for failure, attempts in ((EXHAUSTED, 1), (fake.refusal(), 1), (fake.refusal(100.0), 1), (UNAVAILABLE, calls.ATTEMPTS)):
        service.failures = [failure] * 100
        service.requests.clear()
        with pytest.raises((stiefel.ResourceExhausted, stiefel.Unavailable)):
            session.step(to=5, timeout=10)
        assert len(service.requests) == attempts


def test_who_cannot_be_reached_is_told_in_plain_words(tmp_path):
    with socket.socket() as silent:  # bound, so that nobody else gets it
        silent.bind(("127.0.0.1", 0))
        refused = f"127.0.0.1:{silent.getsockname()[1]}"
        for address in (refused, "no-such-host.invalid:50551", f"unix:{tmp_path}/nobody"):
            with stiefel.Client(address) as client, pytest.raises(stiefel.Unavailable) as caught:
                client.describe()
            assert str(caught.value).startswith(f"cannot reach {address}: ")
            assert not any(word in str(caught.value) for word in ("ares", "ARES", "DNS", "addresses", "UNKNOWN"))


SLOW = {"system": "rigid_body", "step": 1e-3, "method": {"name": "variational", "order": 8, "substeps": 16}, "inertia": [1, 2, 3, 4],
        "initial": {"Q": np.eye(4), "M": np.diag([1.0, 2, 3], 1) - np.diag([1.0, 2, 3], -1)}}


@pytest.mark.parametrize("late", [
    lambda session, to: session.step(to, timeout=0.3), lambda session, to: session.trajectory(to, every=to, timeout=0.3),
    lambda session, to: session.diagnose(to, timeout=0.3), lambda session, to: session.summarize(to, quantities={"M": "max"}, timeout=0.3)], ids=["step", "trajectory", "diagnose", "summarize"])
def test_a_call_that_took_too_long_says_how_long_it_takes(client, late):
    to = 10**9
    with client.create(SLOW) as session:
        with pytest.raises(stiefel.DeadlineExceeded) as caught:
            late(session, to)
        told = re.search(r"took longer than its timeout of 0.3 s; it takes about (\S+) s of one core \((\S+) instructions\)",
                         str(caught.value))
        seconds, work = float(told[1]), float(told[2])
        assert work == pytest.approx(to * session.step_price.work, rel=0.1)
        assert seconds == pytest.approx(work / 5e9, rel=0.1)


@pytest.mark.parametrize("breaks", [[2], [1, 1, 1], [0, 0, 3], [UNAVAILABLE, 2, UNAVAILABLE, 1], [-1]],
                         ids=lambda breaks: " ".join(str(b) for b in breaks))
def test_a_broken_stream_resumes_where_it_stopped(service, session, breaks):
    service.failures = list(breaks)
    service.requests.clear()
    run = session.trajectory(to=155, every=3)
    assert list(run.step) == [*range(0, 155, 3), 155]
    assert list(run["x"].ravel()) == list(run.step) and list(run.time) == [step * 0.5 for step in run.step]
    assert run.outcome == "REACHED"
    assert len(service.requests) == len(breaks) + 1


def test_a_timeout_is_that_of_the_whole_trajectory(service, session, clock):
    """Every stream breaks after its first message, so each by itself is short: 14 messages take 420 s."""
    service.failures = [1] * 1000
    with pytest.raises(stiefel.DeadlineExceeded) as caught:
        session.trajectory(to=10**4, every=1, timeout=400)
    assert clock.now in (420, 450)  # the last stream, which has no time, may still reach the server
    partial = caught.value.partial
    assert f"{partial.samples} samples had arrived" in str(caught.value)
    assert partial.outcome is stiefel.Outcome.CANCELLED and partial.run_status.message
    assert list(partial.step) == list(range(140))
    assert list(partial["x"].ravel()) == list(partial.step)
    assert partial.computed_steps == 14 * 9


def test_other_errors_have_what_arrived_too(service, session):
    service.failures = [2, EXHAUSTED]
    with pytest.raises(stiefel.ResourceExhausted) as caught:
        session.trajectory(to=100)
    assert list(caught.value.partial.step) == list(range(20))
    with pytest.raises(stiefel.ResourceExhausted) as caught:
        service.failures = [EXHAUSTED]
        session.step(to=5)
    assert caught.value.partial is None


def test_a_refusal_with_a_time_is_made_again_after_it(service, session, monkeypatch):
    """Until the deadline, or for the client's timeout where the call has none."""
    slept = []
    monkeypatch.setattr(session._connection, "rest", lambda seconds, away: slept.append(seconds))
    for call in (session.step, session.drive().step, session.trajectory):
        service.failures = [fake.refusal(0.25)] * 30
        assert np.max(call(to=5).step) == 5 and not service.failures
        assert all(0.25 <= pause <= 0.25 + min(0.01 * 2**attempt, 1) for attempt, pause in enumerate(slept)) and len(slept) == 30
        slept.clear()
    session._connection.timeout = 0
    service.failures = [fake.refusal(0.25)] * 30
    with pytest.raises(stiefel.ResourceExhausted) as caught:
        session.drive().step(to=5)
    assert caught.value.retry_delay == 0.25 and len(slept) == 5


def test_a_stream_and_a_drive_that_are_refused_go_on(service, session):
    service.failures = [fake.refusal(0.001)] * 2
    assert [int(batch.step[-1]) for batch in session.stream(to=15)] == [9, 15]
    with session.drive() as drive:
        service.failures = [fake.refusal(0.001)] * 3
        assert drive.step(4).step == 4
        service.failures = [fake.refusal()]
        with pytest.raises(stiefel.ResourceExhausted):
            drive.step(5)
        assert drive.step(6).step == 6
