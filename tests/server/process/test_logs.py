"""The lines of the log: one a call, valid JSON whatever a caller sends, and nothing secret."""
import json
import signal
import threading

import grpc
import pytest

import stiefel
from conftest import BODY, eventually
from stiefel import v1 as pb
from stiefel.v1 import simulation_pb2_grpc as rpc

TRACE = "4bf92f3577b34da6a3ce929d0e0e4736"
PARENT = f"00-{TRACE}-00f067aa0ba902b7-01"


def of(lines, method):
    return [line for line in lines if line.get("method") == method and line["message"] == "rpc"]


def test_a_call_is_a_line_with_peer_work_and_trace(serve):
    """However it ends, also where its request is no message: with the caller's ids, cut and escaped."""
    process = serve("--log-format", "json", "--log-level", "debug")
    with stiefel.Client(process.address) as client, process.channel() as channel:
        stub, session = rpc.SimulationServiceStub(channel), client.create(BODY)
        work = stub.Step(pb.StepRequest(session_id=session.id, to=100_000), metadata=[("traceparent", PARENT)], timeout=60).work
        for header in ("", "x" * 20, PARENT[:-1]):
            stub.Describe(pb.DescribeRequest(), metadata=[("traceparent", header)], timeout=60)
        stub.Describe(pb.DescribeRequest(), metadata=[("x-request-id", 'a"b\\c {"level":"error"}')], timeout=60)
        for method in ("CreateSession", "Stream"):
            with pytest.raises(grpc.RpcError) as refused:
                list(channel.unary_stream(f"/stiefel.v1.SimulationService/{method}")(b"\xff" * 64, timeout=60))
            assert refused.value.code() is grpc.StatusCode.INVALID_ARGUMENT
    lines = process.log()
    (step,) = of(lines, "Step")
    assert step["session"] == session.id and step["code"] == "OK" and step["peer"].startswith("ipv4:127.0.0.1:")
    assert step["trace_id"] == TRACE and step["request_id"] and step["steps"] == 100_000
    assert 0 < work <= step["work"] < 2 * work
    assert not any("trace_id" in line for line in of(lines, "Describe"))
    assert of(lines, "Describe")[-1]["request_id"] == 'a"b\\c {"level":"error"}'
    for method in ("CreateSession", "Stream"):
        line = of(lines, method)[-1]
        assert line["code"] == "INVALID_ARGUMENT" and f"{method}Request" in line["error"]


HOSTILE = ['quote"', "back\\slash", "new\nline", "tab\t", "nul\0", "escape\x1b[31m", "\u2028 separator", "\ud7ff\uffff",
           '","level":"error","message":"forged', "{}%s%n{0}", "é" * 200, "😀" * 100, "x" * 100_000]


@pytest.mark.parametrize("form", ["json", "text"])
def test_hostile_ids(serve, form):
    process = serve("--log-format", form, "--log-level", "debug")
    with process.channel() as channel:
        stub = rpc.SimulationServiceStub(channel)
        for text in HOSTILE:
            with pytest.raises(grpc.RpcError):
                stub.GetSession(pb.GetSessionRequest(session_id=text), timeout=60)
            with pytest.raises(grpc.RpcError):
                stub.Step(pb.StepRequest(session_id=text), timeout=60)
            replies = list(stub.Drive(iter([pb.DriveRequest(session_id=text)]), timeout=60))
            assert [reply.error.code for reply in replies] == [grpc.StatusCode.INVALID_ARGUMENT.value[0]]
    process.child.stdin.close()
    process.child.wait(60)
    lines = process.child.stderr.read().split("\n")
    assert lines.pop() == ""
    # One line a call and no more: nothing that a caller sends begins another.
    assert sum(" rpc " in line or '"rpc"' in line for line in lines) == 3 * len(HOSTILE)
    if form == "json":
        objects = [json.loads(line) for line in lines]
        assert all(line["level"] in ("debug", "info", "warning") for line in objects)
        assert all(len(line.get("session", "")) <= 128 for line in objects)
    else:
        assert not any("\x1b" in line or "\0" in line for line in lines)


def test_calls_go_on_while_the_log_is_not_read(serve):
    """A pipe holds 64 KiB, some 300 lines, and the queue 1024; of more the oldest are dropped and counted."""
    process, calls = serve("--log-format", "json", "--log-level", "debug"), 2000
    with process.channel() as channel:
        stub = rpc.SimulationServiceStub(channel)
        for _ in range(calls):
            stub.ListSessions(pb.ListSessionsRequest(), timeout=60)
        lines = []
        reader = threading.Thread(target=lambda: lines.extend(map(json.loads, process.child.stderr)))
        reader.start()
        assert eventually(lambda: len(lines) > 100)
        stub.ListSessions(pb.ListSessionsRequest(), timeout=60)
    process.stop()
    reader.join(60)
    written = of(lines, "ListSessions")
    dropped = [line for line in lines if "dropped" in line["message"]]
    assert 1000 < len(written) < calls and written[-1]["code"] == "OK"
    assert sum(line["count"] for line in dropped) + len(written) == calls + 1
    assert all(line["level"] == "warning" for line in dropped)


def test_the_server_answers_while_nobody_reads_the_log_lines_of_its_libraries(serve):
    """Six hundred lines of gRPC or of protobuf would fill the pipe twice; the server answers and ends in time."""
    process = serve()
    with process.channel() as channel:
        stub = rpc.SimulationServiceStub(channel)
        for _ in range(600):  # a name that is not UTF-8
            with pytest.raises(grpc.RpcError) as refused:
                channel.unary_unary("/stiefel.v1.SimulationService/Step")(b"\x0a\1\xff", timeout=30)
            assert refused.value.code() is grpc.StatusCode.INVALID_ARGUMENT
        for _ in range(600):
            with pytest.raises(grpc.RpcError) as refused:
                stub.ListSessions(pb.ListSessionsRequest(page_token="x" * 200), timeout=30, compression=grpc.Compression.Gzip)
            assert refused.value.code() is grpc.StatusCode.UNIMPLEMENTED
        for _ in range(2000):  # and lines of the server's own, which nobody reads either
            with pytest.raises(grpc.RpcError):
                stub.GetSession(pb.GetSessionRequest(session_id="x" * 128), timeout=10)
        assert stub.Describe(pb.DescribeRequest(), timeout=10).version
    process.child.send_signal(signal.SIGTERM)
    assert process.child.wait(20) == 0
