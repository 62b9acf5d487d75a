"""States, checkpoints and scenes that are larger than a message, against a server that sends them in parts."""
import grpc
import numpy as np
import pytest

import fake
import stiefel
from stiefel import v1 as pb
from stiefel._wire.arrays import Assembly

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
        session = client.get("fake")
        session.client = client
        yield session


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


def test_arrays_of_the_scene_that_a_reply_leaves_out_are_fetched_once(service, session):
    streams = [request for request in service.requests if isinstance(request, pb.StreamRequest)]
    assert streams == []  # only when somebody looks
    service.failures = [UNAVAILABLE, 1]
    assert session.scene["initial"]["Q"] == fake.Q.tolist()
    calls_made = len(service.requests)
    assert session.scene["step"] == 0.5 and session.scene["system"] == "rigid_body"
    assert len(service.requests) == calls_made


def test_the_warnings_of_a_tradeoff_are_issued(service, session):
    def warned(part):
        if part.HasField("setup"):
            part.setup.warnings.append("the work of a step of heun is estimated")
        return part
    service.spoil = warned
    with pytest.warns(stiefel.SceneWarning, match="the work of a step of heun is estimated") as caught:
        session.client.tradeoff({"system": "rigid_body"})
    assert len(caught) == 1


@pytest.mark.parametrize("offsets", [[4], [0, 8], [0, 4], [0, 4, 4]], ids=str)
def test_a_part_that_is_missing_is_noticed(offsets):
    found = {part.offset: part for part in fake.parts("large", large(1))}
    assembly = Assembly()
    with pytest.raises(stiefel.CorruptReply, match="a part of the array large is missing"):
        assembly.take([found[offset] for offset in offsets])
        assembly.finish()
