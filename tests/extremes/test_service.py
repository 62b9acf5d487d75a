"""The service at its extremes: a request of 10^9 steps, a million samples, 10^4 sessions, every limit
and one past it."""
import time

import numpy as np
import pytest

import stiefel
from conftest import LONG, SANITIZED
from stiefel import v1 as pb

FAR = 10**9
BODY = {"system": "rigid_body", "method": {"name": "variational"}, "step": 0.01,
        "body": {"moments": [1, 2, 3], "angular_velocity": [0.001, 1, 0.001]}}


@pytest.fixture
def session(client):
    with client.create(BODY) as session:
        session.client = client
        yield session


@pytest.mark.skipif(not LONG, reason="takes minutes")
def test_all_of_them(session):
    state = session.step(to=FAR, timeout=None)
    assert state.outcome == "REACHED" and state.step == FAR
    drift = max(i.drift for i in session.diagnose(to=FAR).invariants)
    assert drift <= 100 * 2**-53 * FAR**0.5  # compensated


# A million samples

def test_a_million_samples(session):
    count = 10**6
    run = session.trajectory(to=count, every=1, fields=["quaternion"])
    assert run.outcome == "REACHED" and run.samples == count + 1 and (run.step == np.arange(count + 1)).all()
    np.testing.assert_array_equal(run["quaternion"][-1], session.step(to=count, fields=["quaternion"])["quaternion"])
    np.testing.assert_allclose(np.linalg.norm(run["quaternion"], axis=1), 1, atol=1e-13)


# Many sessions

def test_ten_thousand_sessions():
    count = 10_000 if LONG else 1000
    with stiefel.Server.start(arguments=["--max-sessions", str(count)]) as server, \
            stiefel.Client(server.address) as client:
        before = resident_bytes(server)
        sessions = [client.create(BODY, id=f"{k:05}") for k in range(count)]
        each = (resident_bytes(server) - before) / count
        with stiefel.Client(server.address, timeout=0.5) as impatient, \
                pytest.raises(stiefel.ResourceExhausted, match="max_sessions|sessions") as full:
            impatient.create(BODY)
        assert full.value.reason == "TOO_MANY_SESSIONS" and full.value.metadata["max_sessions"] == str(count)
        assert [session.id for session in client.list()] == [f"{k:05}" for k in range(count)]
        for session in sessions[::97]:
            assert session.step(to=10).step == 10
        sessions[0].delete()
        assert client.create(BODY).created
    assert SANITIZED or each <= 65536


def resident_bytes(server):
    with open(f"/proc/{server.process.pid}/statm", encoding="ascii") as statm:
        return int(statm.read().split()[1]) * 4096


# Every limit that Describe lists, and one past it

@pytest.fixture
def limits(client):
    return client.describe().limits


def large(n):
    """Returns a body in n dimensions, without a frame, that rotates in one plane only."""
    M = np.zeros((n, n))
    M[0, 1], M[1, 0] = 1, -1
    return {"system": "rigid_body", "method": {"name": "rk4"}, "inertia": np.linspace(1, 2, n), "initial": {"M": M},
            "step": 1e-3}


def refused(call, field, value, rule, error=stiefel.InvalidArgument):
    """Expects a refusal that names field, value and rule."""
    with pytest.raises(error) as caught:
        call()
    (violation,) = caught.value.violations
    assert violation.field == field and str(value) in violation.description and rule in violation.description


def test_max_dimension(client, limits):
    with client.create(large(limits.max_dimension)) as session:
        assert session.step(to=1).outcome == "REACHED"
    past = limits.max_dimension + 1
    refused(lambda: client.create(large(past)), "scene.inertia", f"{past} numbers", f"2 to {limits.max_dimension}")


def test_max_step(client, limits):
    with client.create({**BODY, "method": {"name": "exact"}}) as session:
        assert session.step(to=limits.max_step).step == limits.max_step
        past = limits.max_step + 1
        rule = "must be"  # of Python for -1, of the server beyond the limit
        for call, field in [(lambda: session.step(to=past), "to"), (lambda: session.step(to=-1), "to"),
                            (lambda: session.diagnose(to=past), "to"), (lambda: session.fork(at=past), "from_step"),
                            (lambda: list(session.stream(to=past)), "to")]:
            refused(call, field, "-1" if call is None else "", rule)


def test_max_cached_steps(client, limits):
    with client.create(BODY) as session:
        session.step(to=2_000_000)
        kept = len(client.get(session.id)._message.cached_steps)
    assert 1 < kept <= limits.max_cached_steps


def test_max_cached_bytes(client, limits):
    """With states of one megabyte there is room for about fifty."""
    n = 256
    with client.create(large(n)) as session:
        session.step(to=200 if LONG else 20)
        kept = len(client.get(session.id)._message.cached_steps)
        state = len(session.step(to=0, checkpoint=True).checkpoint)
    assert kept * state <= limits.max_cached_bytes


def test_idle_timeout():
    with stiefel.Server.start(arguments=["--idle-timeout", "0.2"]) as server, stiefel.Client(server.address) as client:
        assert client.describe().limits.idle_timeout.ToMilliseconds() == 200
        client.create(BODY, id="idle")
        deadline = time.monotonic() + 30
        while any(client.list()) and time.monotonic() < deadline:  # listing does not renew sessions
            time.sleep(0.05)
        with pytest.raises(stiefel.NotFound):
            client.get("idle")


@pytest.mark.skipif(not LONG, reason="a gigabyte of memory")
def test_max_message_bytes(client, limits):
    """A message at the limit is read and refused for its content; a larger one is not read."""
    with client.create(BODY) as session:
        request = pb.CreateSessionRequest(session_id="large", scene=session._resolved())
    room = limits.max_message_bytes - request.ByteSize() - 16
    request.checkpoint = bytes(room)
    request.session_id += "x" * (limits.max_message_bytes - request.ByteSize())
    assert request.ByteSize() == limits.max_message_bytes
    refused(lambda: client._connection.call("CreateSession", request), "checkpoint", room, "damaged")
    request.session_id += "x"
    with pytest.raises(stiefel.ResourceExhausted, match=str(limits.max_message_bytes)):
        client._connection.call("CreateSession", request)


# Limits that only the refusal names

def with_method(**method):
    return {**BODY, "method": {"name": "variational", **method}}


def frames(n, N):
    return {"inertia": np.ones(N), "pairs": [(np.eye(n, N), np.roll(np.eye(n, N), 1, axis=1))]}


@pytest.mark.parametrize("tolerance, past", [(1e-15, 0.99e-15), (1.0, 1.01)])
def test_tolerances(client, tolerance, past):
    with client.create(with_method(name="adaptive", tolerance=tolerance)) as session:
        assert session.scene["method"]["tolerance"] == tolerance
    refused(lambda: client.create(with_method(name="adaptive", tolerance=past)), "scene.method.tolerance", past, "1e-15 to 1")


def resting_frame(n, N):
    return {"system": "stiefel", "method": {"name": "rk4"}, "inertia": np.ones(N), "step": 1e-3,
            "initial": {"Q": np.eye(n, N), "S": np.zeros((n, N))}}


def test_frames_of_too_many_rows(client, limits):
    n = limits.max_dimension
    if LONG:
        client.create(resting_frame(n, n + 1)).delete()
    refused(lambda: client.create(resting_frame(n + 1, n + 2)), "scene.initial.Q", f"{n + 1} x {n + 2}", f"n ≤ {n}")


def test_frames_are_as_large_as_the_memory_of_a_search(client):
    assert client.geodesics(**frames(1, 4000))[0].outcome == "REACHED"
    many = frames(5, 30_000) | {"inertia": np.linspace(1, 10, 30_000)}
    refused(lambda: client.geodesics(**many)[0], "pairs[0].Q_0", "5 x 30000", "at most 512 MiB")
