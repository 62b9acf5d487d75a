"""Bytes that are no message: the caller is told so, and the log too."""
import grpc
import pytest

SERVICE = "/stiefel.v1.SimulationService/"


@pytest.mark.parametrize("method", ["Step", "CreateSession", "Describe", "Diagnose", "GetSession"])
def test_bytes_that_are_no_request(serve, method):
    process = serve("--log-level", "warn")
    with process.channel() as channel:
        call = channel.unary_unary(SERVICE + method, request_serializer=bytes, response_deserializer=bytes)
        with pytest.raises(grpc.RpcError) as refused:
            call(b"\xff\xff\xff", timeout=10)
    assert refused.value.code() == grpc.StatusCode.INVALID_ARGUMENT
    assert refused.value.details() == "the request is no message of the type that the method takes"
    assert process.stop() == 0
    lines = process.child.stderr.read().splitlines()
    assert len(lines) == 1 and f'method="{SERVICE}{method}"' in lines[0] and "no message" in lines[0]


def test_a_stream_of_no_request(serve):
    with serve().channel() as channel:
        call = channel.unary_stream(SERVICE + "Stream", request_serializer=bytes, response_deserializer=bytes)
        with pytest.raises(grpc.RpcError) as refused:
            list(call(b"\xff\xff\xff", timeout=10))
    assert refused.value.code() == grpc.StatusCode.INVALID_ARGUMENT


def test_a_method_that_there_is_not(serve):
    with serve().channel() as channel:
        call = channel.unary_unary(SERVICE + "NoSuch", request_serializer=bytes, response_deserializer=bytes)
        with pytest.raises(grpc.RpcError) as refused:
            call(b"", timeout=10)
    assert refused.value.code() == grpc.StatusCode.UNIMPLEMENTED
