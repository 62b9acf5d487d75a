"""A client that is closed says so, wherever it is used."""
import threading

import pytest

import stiefel

SCENE = {"system": "rigid_body", "method": {"name": "variational"}, "step": 0.01,
         "body": {"moments": [1, 2, 3], "angular_velocity": [0.1, 2, 0.1]}}


@pytest.fixture
def closed(client):
    """A session whose client is closed, with an idle drive, a used drive and a stream that has begun."""
    own = stiefel.Client(client.address)
    session = own.create(SCENE)
    session.client, session.idle, session.used, session.begun = own, session.drive(), session.drive(), session.stream(to=10**9)
    session.used.step(3)
    next(session.begun)
    own.close()
    yield session
    client.delete(session.id)


@pytest.mark.parametrize("use", [
    lambda s: s.client.describe(), lambda s: s.client.create(SCENE), lambda s: s.client.get(s.id),
    lambda s: list(s.client.list()), lambda s: s.client.tradeoff(SCENE), lambda s: s.step(to=1),
    lambda s: s.trajectory(to=1), lambda s: list(s.stream(to=1)), lambda s: s.diagnose(to=1), lambda s: s.fork(at=1),
    lambda s: s.delete(), lambda s: s.idle.step(1), lambda s: s.used.step(1), lambda s: list(s.begun),
    lambda s: s.drive().step(1), lambda s: s.__enter__().__exit__(None, None, None),
], ids=["describe", "create", "get", "list", "tradeoff", "step", "trajectory", "stream", "diagnose", "fork", "delete",
        "idle drive", "used drive", "begun stream", "new drive", "block"])
def test_every_use_says_so(closed, use):
    with pytest.raises(stiefel.Closed, match="^the client of .* is closed$"):
        use(closed)


def test_to_close_from_another_thread_ends_a_trajectory(client):
    own = stiefel.Client(client.address)
    session = own.create(SCENE)
    threading.Timer(0.3, own.close).start()
    with pytest.raises(stiefel.Closed) as caught:
        session.trajectory(to=10**12, every=10**10)
    assert caught.value.partial is not None
    client.delete(session.id)


def test_what_ends_a_block_is_not_hidden(client):
    own = stiefel.Client(client.address)
    with pytest.raises(ZeroDivisionError):
        with own.create(SCENE) as session:
            own.close()
            1 / 0
    client.delete(session.id)


def test_the_end_of_a_block_asks_nothing_of_a_server_that_is_gone(without_pauses):
    """The error of the call is the program's; the session is gone with its server."""
    with stiefel.Server.start() as server, stiefel.Client(server.address) as client:
        with client.create(SCENE) as session, session.drive() as drive:
            server.stop()
            for call in (session.step, drive.step, session.trajectory, session.diagnose):
                with pytest.raises(stiefel.Unavailable):
                    call(to=3)
        with pytest.raises(ZeroDivisionError):
            with session:
                1 / 0
