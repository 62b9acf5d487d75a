"""The samples of a stream: their steps, their fields, and their number in a message."""
import numpy as np
import pytest

import scenes
from stiefel import v1 as pb


@pytest.fixture(scope="module")
def session(client):
    with client.create(scenes.rigid_body()) as session:
        yield session


def messages(session, **request):
    if "start" in request:
        request["from"] = request.pop("start")
    return list(session._connection.stub.Stream(pb.StreamRequest(session_id=session.id, **request), timeout=60))


def test_every_message_tells_what_the_stream_has_cost(client):
    """A client whose stream breaks thus knows the cost so far."""
    with client.create(scenes.rigid_body()) as fresh:
        replies = messages(fresh, to=20_000)
    costs = [reply.computed_steps for reply in replies]
    assert len(costs) > 2 and costs == sorted(costs) and costs[-1] == 20_000
    assert all(reply.computed_steps >= reply.steps[-1] for reply in replies if reply.steps)


@pytest.mark.parametrize("request_, steps", [
    (dict(to=0), [0]),
    (dict(to=4), [0, 1, 2, 3, 4]),
    (dict(to=10, every=3), [0, 3, 6, 9, 10]),
    (dict(to=9, every=3), [0, 3, 6, 9]),
    (dict(start=5, to=11, every=4), [5, 9, 11]),
    (dict(start=7, to=7), [7]),
    (dict(start=3, to=5, every=100), [3, 5]),
])
def test_from_every_and_always_the_last(session, request_, steps):
    replies = messages(session, **request_)
    assert [step for reply in replies for step in reply.steps] == steps
    assert [time for reply in replies for time in reply.times] == [step * 0.01 for step in steps]
    assert [reply.HasField("run_status") for reply in replies] == [False] * (len(replies) - 1) + [True]
    assert replies[-1].run_status.outcome == pb.OUTCOME_REACHED


def test_blocks_are_the_default_fields(session):
    assert set(session.step(to=1).fields) == {"Q", "M"}
    assert list(session.trajectory(to=1).fields) == list(session.step(to=1).fields)


def test_every_declared_field_can_be_had(client):
    """Fields come in the order asked for, with the shapes of the catalogue."""
    systems = {system.name: system for system in client.describe().systems}
    for scene in (scenes.rigid_body(), scenes.moser_veselov(), scenes.body(), scenes.free(5)):
        with client.create(scene) as session:
            n = session.step(to=0, fields=["M"])["M"].shape[0]
            for field in systems[scene["system"]].fields:
                if "N" not in field.shape and n != 3:
                    continue
                rows, cols = (eval(size, {}, {"N": n}) for size in field.shape.split(" x "))
                shape = (rows, cols) if field.name[0].isupper() else (cols,)
                name = field.name.replace("SEQUENCE", "ZXZ")
                assert session.step(to=3, fields=[name])[name].shape == shape, name


def test_the_order_of_fields_is_the_request_s(session):
    assert list(session.step(to=2, fields=["M", "Q"]).fields) == ["M", "Q"]
    assert list(session.trajectory(to=2, fields=["M", "Q"]).fields) == ["M", "Q"]


def test_many_samples_travel_in_a_message(session):
    replies = messages(session, to=20_000)
    sizes = [reply.ByteSize() for reply in replies]
    assert sum(len(reply.steps) for reply in replies) == 20_001
    assert max(sizes) <= 256 << 10
    assert np.median(sizes) >= 32 << 10


def test_a_large_sample_travels_alone(client):
    with client.create(scenes.free(150)) as session:
        replies = messages(session, to=2)
    assert [len(reply.steps) for reply in replies if reply.steps] == [1, 1, 1]
    assert all(reply.fields[0].value.shape == [1, 150, 150] for reply in replies if reply.steps)


def test_diagnose_tells_what_is_kept(session):
    diagnosis = session.diagnose(to=2000)
    invariants = {invariant.name: invariant for invariant in diagnosis.invariants}
    assert diagnosis.step == 2000 and diagnosis.time == 20.0
    assert {"energy", "spatial_momentum[0,1]"} <= set(invariants)
    assert any(name.startswith("manakov") for name in invariants)
    for invariant in diagnosis.invariants:
        assert invariant.scale > 0
        rounding = np.spacing(max(abs(invariant.value), abs(invariant.initial))) / invariant.scale
        assert invariant.drift == pytest.approx(
            abs(invariant.value - invariant.initial) / invariant.scale, abs=rounding)  # computed before rounding
        assert invariant.drift < 1e-13
    assert diagnosis.orthogonality < 1e-13
    assert 0.01 < diagnosis.domain.h_omega < 0.1
    assert diagnosis.domain.largest_step > 0.01


def test_diagnose_only_what_was_asked(session):
    names = [invariant.name for invariant in session.diagnose(to=5, invariants=["energy"]).invariants]
    assert names == ["energy"]
    names = [invariant.name for invariant in session.diagnose(to=5, invariants=["spatial_momentum"]).invariants]
    assert len(names) == 3 and all(name.startswith("spatial_momentum[") for name in names)


def test_drive_remembers_session_and_fields(session):
    """On the wire only the first request names the session, and the fields named last stay in force."""
    requests = [pb.DriveRequest(session_id=session.id, to=4), pb.DriveRequest(to=6, fields=["M"]),
                pb.DriveRequest(to=5, return_checkpoint=True)]
    replies = list(session._connection.stub.Drive(iter(requests), timeout=60))
    assert [reply.step.sample.step for reply in replies] == [4, 6, 5]
    assert [[field.name for field in reply.step.sample.fields] for reply in replies] == [["Q", "M"], ["M"], ["M"]]
    assert [bool(reply.step.checkpoint) for reply in replies] == [False, False, True]


def test_drive_stays_with_its_session(session):
    requests = [pb.DriveRequest(session_id=session.id, to=1), pb.DriveRequest(session_id="another", to=2),
                pb.DriveRequest(to=3)]
    replies = list(session._connection.stub.Drive(iter(requests), timeout=60))
    assert [reply.WhichOneof("result") for reply in replies] == ["step", "error", "step"]
    assert "session_id" in replies[1].error.message and replies[2].step.sample.step == 3
