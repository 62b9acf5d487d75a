"""The client names sessions, and every call on a session is idempotent."""
import uuid

import pytest

import scenes
import stiefel
from stiefel import v1 as pb
from stiefel._scene import to_message


@pytest.fixture
def id(client):
    name = f"conformance-{uuid.uuid4()}"
    yield name
    client.delete(name)


def test_the_same_id_and_another_scene_is_refused(client, id):
    client.create(scenes.rigid_body(), id=id)
    with pytest.raises(stiefel.AlreadyExists, match=id):
        client.create(scenes.rigid_body(step=0.02), id=id)
    assert client.get(id)._resolved().step == 0.01


def test_deleting_an_unknown_id_succeeds(client, id):
    client.delete(id)
    client.create(scenes.rigid_body(), id=id)
    client.delete(id)
    client.delete(id)
    with pytest.raises(stiefel.NotFound, match=id):
        client.get(id)


def test_every_default_is_resolved(client, id):
    scene = client.create(scenes.rigid_body(), id=id)._resolved()
    assert (scene.method.order, scene.method.substeps, scene.method.arithmetic) == (2, 1, "compensated")


def test_get_tells_cursor_and_cached_steps(client, id):
    session = client.create(scenes.rigid_body(), id=id)
    session.step(to=1234)
    message = client.get(id)._message
    assert message.cursor == 1234
    assert message.cached_steps[0] == 0 and list(message.cached_steps) == sorted(message.cached_steps)
    assert len(message.cached_steps) <= client.describe().limits.max_cached_steps
    assert message.numerics_id == client.describe().numerics_id
    assert message.step_price.work > 0 and message.step_price.bytes == 2 * 72
    assert message.expire_time.seconds > message.create_time.seconds


def test_a_reply_has_the_resolved_scene_on_request(client, id):
    def created(asked):
        request = pb.CreateSessionRequest(session_id=id, scene=to_message(scenes.rigid_body()), return_scene=asked)
        return client._connection.call("CreateSession", request).session

    assert not created(False).HasField("scene")
    full = created(True)
    assert set(full.scene.initial) == {"Q", "M"} and full.system == "rigid_body" and full.scene.HasField("method")


def test_list_is_ordered_and_paged(client):
    prefix = f"list-{uuid.uuid4()}"
    ids = [f"{prefix}-{i}" for i in range(5)]
    for name in reversed(ids):
        client.create(scenes.moser_veselov(), id=name)
    token, found = "", []
    while True:
        page = client._connection.call("ListSessions", pb.ListSessionsRequest(page_size=2, page_token=token))
        assert len(page.sessions) <= 2 and not any(session.HasField("scene") for session in page.sessions)
        found += [session.session_id for session in page.sessions]
        token = page.next_page_token
        if not token:
            break
    assert found == sorted(found)
    assert [name for name in found if name.startswith(prefix)] == ids
    assert {session.id for session in client.list()} >= set(ids)
    assert len(client._connection.call("ListSessions", pb.ListSessionsRequest(page_size=10**9)).sessions) >= 5  # clamped
    for name in ids:
        client.delete(name)


def test_a_checkpoint_of_another_scene_is_refused(client):
    with client.create(scenes.rigid_body()) as session:
        checkpoint = session.step(to=5, checkpoint=True).checkpoint
    for scene in (scenes.rigid_body(step=0.02), scenes.free(4)):
        with pytest.raises((stiefel.InvalidArgument, stiefel.FailedPrecondition), match="checkpoint"):
            client.create(scene, checkpoint=checkpoint)


def test_replies_say_what_was_computed(client, id):
    session = client.create(scenes.rigid_body(), id=id)
    assert session.step(to=100).computed_steps == 100
    assert session.step(to=150).computed_steps == 50
    assert session.step(to=150).computed_steps == 0
    assert session.step(to=0).computed_steps == 0
