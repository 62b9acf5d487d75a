"""This client at a server that has fewer calls, as one of an earlier version does."""
from concurrent.futures import ThreadPoolExecutor

import grpc
import pytest

import fake
import stiefel
from stiefel import v1 as pb


@pytest.fixture
def session(tmp_path):
    """Of a server that has GetSession, Stream and Step alone."""
    service, server, address = fake.Fake(), grpc.server(ThreadPoolExecutor(4)), f"unix:{tmp_path}/older"
    unary = {"GetSession": pb.GetSessionRequest, "Step": pb.StepRequest}
    handlers = {name: grpc.unary_unary_rpc_method_handler(getattr(service, name), request.FromString,
                                                          lambda reply: reply.SerializeToString())
                for name, request in unary.items()}
    handlers["Stream"] = grpc.unary_stream_rpc_method_handler(service.Stream, pb.StreamRequest.FromString,
                                                              lambda reply: reply.SerializeToString())
    server.add_generic_rpc_handlers((grpc.method_handlers_generic_handler("stiefel.v1.SimulationService", handlers),))
    server.add_insecure_port(address)
    server.start()
    with stiefel.Client(address) as client:
        session = client.get("fake")
        session.client = client
        yield session
    server.stop(None)


@pytest.mark.parametrize("call", [
    lambda session: session.summarize(10, {"energy": "drift"}),
    lambda session: session.events(10, {"field": "Q", "coefficients": [1]}),
    lambda session: session.trajectory(times=[0.25]),
    lambda session: session.diagnose(to=1),
    lambda session: session.drive().step(1),
    lambda session: session.client.describe(),
    lambda session: session.client.tradeoff({"system": "rigid_body"}),
], ids=["summarize", "events", "times", "diagnose", "drive", "describe", "tradeoff"])
def test_a_call_that_the_server_does_not_have_says_which_version_it_needs(session, call):
    with pytest.raises(stiefel.StiefelError, match=f"does not have this call.*stiefel-server {stiefel.__version__}"):
        call(session)


def test_the_calls_that_it_has_work(session):
    assert session.step(to=5).step == 5
    assert list(session.trajectory(to=20).step) == list(range(21))
