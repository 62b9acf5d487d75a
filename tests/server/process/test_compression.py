"""Compressed requests: none is inflated, whatever it would become."""
import grpc
import pytest

from stiefel import v1 as pb
from stiefel.v1 import simulation_pb2_grpc as rpc

ALGORITHMS = [grpc.Compression.Gzip, grpc.Compression.Deflate]
BOMB = "x" * 200_000_000  # 200 kB compressed; below the limit of a message, 256 MiB


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_a_compressed_request_is_refused_before_it_is_inflated(serve, algorithm):
    process = serve()
    before = process.memory()
    with process.channel(compression=algorithm) as channel:
        stub = rpc.SimulationServiceStub(channel)
        calls = [lambda: stub.CreateSession(pb.CreateSessionRequest(session_id=BOMB), timeout=60),
                 lambda: list(stub.Stream(pb.StreamRequest(session_id=BOMB), timeout=60)),
                 lambda: list(stub.Drive(iter([pb.DriveRequest(session_id=BOMB)]), timeout=60))]
        for call in calls:
            with pytest.raises(grpc.RpcError) as refused:
                call()
            assert refused.value.code() == grpc.StatusCode.UNIMPLEMENTED
            assert "ompression" in refused.value.details()
    assert process.memory() - before < 50e6
    with process.channel() as channel:
        assert rpc.SimulationServiceStub(channel).Describe(pb.DescribeRequest(), timeout=60).version
