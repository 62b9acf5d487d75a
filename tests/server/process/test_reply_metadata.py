"""Every reply tells the numerics id, and the trace id of a call that has one: also where the call is not let in."""
import os
import subprocess

import grpc
import pytest

import stiefel
from conftest import Process
from stiefel import v1 as pb
from stiefel.v1 import simulation_pb2

SERVICE = simulation_pb2.DESCRIPTOR.services_by_name["SimulationService"]
TRACE = "4bf92f3577b34da6a3ce929d0e0e4736"
TRACED = ("traceparent", f"00-{TRACE}-00f067aa0ba902b7-01")


def refusal(channel, method, message, *metadata):
    """The error that ends an RPC."""
    kind = getattr(channel, f"{'stream' if method.client_streaming else 'unary'}_"
                            f"{'stream' if method.server_streaming else 'unary'}")
    with pytest.raises(grpc.RpcError) as error:
        done = kind(f"/{SERVICE.full_name}/{method.name}")(iter([message]) if method.client_streaming else message,
                                                           timeout=60, metadata=[TRACED, *metadata])
        if method.server_streaming:
            list(done)
    return error.value


def numerics_of(process, token=None):
    with stiefel.Client(process.address, token=token) as client:
        return client.describe().numerics_id


@pytest.fixture(scope="module")
def served():
    process = Process("--log-level", "error")
    yield process, numerics_of(process)
    process.stop()


def check(error, code, numerics):
    assert error.code() is code
    # gRPC repeats no call with initial metadata.
    assert not error.initial_metadata()
    assert dict(error.trailing_metadata() or ()).get("stiefel-numerics-id") == numerics
    assert dict(error.trailing_metadata() or ()).get("stiefel-trace-id") == TRACE


@pytest.mark.parametrize("method", [method for method in SERVICE.methods if method.name != "Drive"],
                         ids=lambda method: method.name)
def test_of_bytes_that_are_no_message(served, method):
    process, numerics = served
    with process.channel() as channel:
        check(refusal(channel, method, b"\xff" * 64), grpc.StatusCode.INVALID_ARGUMENT, numerics)


def test_of_callers_who_are_not_let_in(serve, tmp_path):
    made = subprocess.run([os.environ["STIEFEL_SERVER"], "token", "me"], capture_output=True, text=True, check=True)
    token, line = made.stdout.split("\n")[:2]
    (tmp_path / "tokens").write_text(line + "\n")
    process = serve("--tokens", str(tmp_path / "tokens"), "--log-level", "error")
    numerics = numerics_of(process, token)
    with process.channel() as channel:
        for method in SERVICE.methods:
            for metadata in ([], [("authorization", "Bearer unknown")]):
                check(refusal(channel, method, b"", *metadata), grpc.StatusCode.UNAUTHENTICATED, numerics)


def test_once_in_a_reply_of_a_call_that_is_let_in(served):
    process, numerics = served
    with process.channel() as channel:
        stub = channel.unary_unary(f"/{SERVICE.full_name}/Describe", pb.DescribeRequest.SerializeToString,
                                   pb.DescribeResponse.FromString)
        _, call = stub.with_call(pb.DescribeRequest(), timeout=60, metadata=[TRACED])
        assert [value for key, value in call.initial_metadata() if key == "stiefel-numerics-id"] == [numerics]
        assert [value for key, value in call.trailing_metadata() if key == "stiefel-trace-id"] == [TRACE]
