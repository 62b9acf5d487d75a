"""States, checkpoints and scenes that are larger than a message, against a server that sends them in parts."""
import grpc
import numpy as np
import pytest

import fake
import stiefel
from stiefel import v1 as pb
from stiefel.assembly import Assembly

UNAVAILABLE = grpc.StatusCode.UNAVAILABLE


@pytest.fixture
def fake_server(tmp_path):
    service, server, address = fake.serve(tmp_path)
    yield service, address
    server.stop(None)


@pytest.fixture
def service(fake_server):
    return fake_server[0]


@pytest.fixture
def session(fake_server, without_pauses):
    with stiefel.Client(fake_server[1]) as client:
        yield client.get("fake")


def large(step):
    return 10 * step + np.arange(10.0).reshape(2, 5)


def test_a_state_larger_than_a_reply_comes_over_a_stream(session):
    state = session.step(to=7, fields="large", checkpoint=True)
    assert (state.step, state.time, state.outcome, state.checkpoint) == (7, 3.5, "REACHED", b"checkpoint of 7")
    assert (state["large"] == large(7)).all()
    with session.drive() as drive:
        assert (drive.step(3, fields="large")["large"] == large(3)).all()
        assert (drive.step(4)["large"] == large(4)).all()  # fields hold for the requests after


@pytest.mark.parametrize("breaks", [[], [1], [2], [4], [3, 1, 2], [-1]], ids=lambda breaks: " ".join(map(str, breaks)))
def test_a_stream_that_breaks_within_a_sample_sends_it_again(service, session, breaks):
    """Every sample is three messages."""
    service.failures = list(breaks)
    run = session.trajectory(to=4, fields="large")
    assert list(run.step) == [0, 1, 2, 3, 4] and run.outcome == "REACHED"
    assert (run["large"] == [large(step) for step in range(5)]).all()


def test_a_checkpoint_survives_a_break(service, session):
    """Three messages of the sample, then ranges of the checkpoint."""
    for messages in (3, 4, 5):
        service.failures = [messages]
        assert session.step(to=12, fields="large", checkpoint=True).checkpoint == b"checkpoint of 12"


def test_arrays_of_the_scene_that_a_reply_leaves_out_are_fetched_once(service, session):
    streams = [request for request in service.requests if isinstance(request, pb.StreamRequest)]
    assert streams == []  # only when somebody looks
    service.failures = [UNAVAILABLE, 1]
    assert session.scene["initial"]["Q"] == {"rows": 2, "cols": 3, "values": fake.Q.ravel().tolist()}
    calls_made = len(service.requests)
    assert session.scene["step"] == 0.5 and session.scene["system"] == "rigid_body"
    assert len(service.requests) == calls_made


@pytest.mark.parametrize("spoil", [
    lambda message: message.fields and message.fields[0].value.__setattr__("data", bytes(len(message.fields[0].value.data))),
    lambda message: message.steps and message.steps.__setitem__(-1, 1 + message.steps[-1]),
    lambda message: message.checkpoint.data and message.checkpoint.__setattr__("data", bytes(len(message.checkpoint.data))),
    lambda message: setattr(message, "checksum", message.checksum ^ 1),
], ids=["fields", "steps", "checkpoint", "checksum"])
def test_what_was_changed_on_its_way_is_noticed(service, session, spoil):
    def spoiled(message):
        spoil(message)
        return message
    service.spoil = spoiled
    with pytest.raises(stiefel.CorruptReply, match="does not match its numbers: the reply was corrupted") as caught:
        session.step_in_parts(5, ["large"], checkpoint=True)
    assert caught.value.code is grpc.StatusCode.DATA_LOSS


def test_a_damaged_part_of_a_tradeoff_is_noticed(service, session):
    def spoiled(part):
        part.checksum = 1
        return part
    service.spoil = spoiled
    with pytest.raises(stiefel.CorruptReply, match="a part of the trade-off does not match its numbers"):
        session._client.tradeoff({"system": "rigid_body"})
    assert service.requests[-1].checksum


def test_the_warnings_of_a_tradeoff_are_issued(service, session):
    def warned(part):
        if part.HasField("setup"):
            part.setup.warnings.append("the work of a step of heun is estimated")
        return part
    service.spoil = warned
    with pytest.warns(stiefel.SceneWarning, match="the work of a step of heun is estimated") as caught:
        session._client.tradeoff({"system": "rigid_body"})
    assert len(caught) == 1


def test_checksums_may_be_done_without(fake_server):
    service, address = fake_server
    with stiefel.Client(address, checksums=False) as client:
        assert client.get("fake").trajectory(to=3).samples == 4
    assert not any(request.checksum for request in service.requests if isinstance(request, pb.StreamRequest))


@pytest.mark.parametrize("offsets", [[4], [0, 8], [0, 4], [0, 4, 4]], ids=str)
def test_a_part_that_is_missing_is_noticed(offsets):
    found = {part.offset: part for part in fake.parts("large", large(1))}
    assembly = Assembly()
    with pytest.raises(stiefel.CorruptReply, match="a part of the array large is missing"):
        assembly.take([found[offset] for offset in offsets])
        assembly.finish()
