"""Drive: what is no request ends it with an error, and silence does not keep a session."""
import queue

import grpc
import pytest

import stiefel
from conftest import BODY, eventually
from stiefel import v1 as pb
from stiefel.v1 import simulation_pb2_grpc as rpc


@pytest.mark.parametrize("first", [[b"\xff\xff\xff"], [b"\x0a\x05ab"], []], ids=["no message", "cut off", "none"])
def test_without_a_first_request_it_ends_with_an_error(serve, first):
    with serve().channel() as channel:
        drive = channel.stream_stream("/stiefel.v1.SimulationService/Drive", request_serializer=bytes,
                                      response_deserializer=bytes)
        with pytest.raises(grpc.RpcError) as refused:
            list(drive(iter(first), timeout=60))
    assert refused.value.code() == grpc.StatusCode.INVALID_ARGUMENT
    assert "the first message must name a session" in refused.value.details()


def test_a_silent_one_does_not_keep_its_session(serve):
    process = serve("--idle-timeout", "0.4")
    with process.channel() as channel, stiefel.Client(process.address) as client:
        session, stub, requests = client.create(BODY), rpc.SimulationServiceStub(channel), queue.Queue()
        drive = stub.Drive(iter(requests.get, None), timeout=30)
        for to in (1, 2):
            requests.put(pb.DriveRequest(session_id=session.id, to=to))
            assert next(drive).step.sample.step == to
        assert eventually(lambda: not stub.ListSessions(pb.ListSessionsRequest()).sessions)
        requests.put(pb.DriveRequest(to=3))
        reply = next(drive)
        assert reply.error.code == grpc.StatusCode.NOT_FOUND.value[0] and session.id in reply.error.message
        requests.put(None)
        assert list(drive) == []


def test_one_that_is_used_keeps_it(serve):
    process = serve("--idle-timeout", "2")
    with process.channel() as channel, stiefel.Client(process.address) as client:
        session, stub, requests = client.create(BODY), rpc.SimulationServiceStub(channel), queue.Queue()
        drive = stub.Drive(iter(requests.get, None), timeout=30)
        for to in range(1, 9):
            requests.put(pb.DriveRequest(session_id=session.id, to=to))
            assert next(drive).step.sample.step == to
            assert not eventually(lambda: not stub.ListSessions(pb.ListSessionsRequest()).sessions, 0.3)
        requests.put(None)
