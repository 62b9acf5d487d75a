"""The lines of the log: one a call, valid JSON whatever a caller sends, and nothing secret."""
import json
import signal
import threading
from collections import Counter

import grpc
import pytest

import stiefel
from conftest import BODY, eventually
from stiefel import v1 as pb
from stiefel.v1 import simulation_pb2_grpc as rpc

TRACE = "4bf92f3577b34da6a3ce929d0e0e4736"
PARENT = f"00-{TRACE}-00f067aa0ba902b7-01"


@pytest.fixture
def logged(serve):
    """Runs calls against a server and returns its log as objects: with a line for every call, unless told otherwise."""
    def logged(work, *arguments, level="debug"):
        process = serve("--log-format", "json", "--log-level", level, *arguments)
        with process.channel() as channel:
            work(rpc.SimulationServiceStub(channel), process)
        process.child.stdin.close()
        process.child.wait(60)
        text = process.child.stderr.read()
        return [json.loads(line) for line in text.splitlines()]
    return logged


def create(stub, process, **more):
    with stiefel.Client(process.address, **more) as client:
        session = client.create(BODY)
        return session.id


def of(lines, method, message="rpc"):
    return [line for line in lines if line.get("method") == method and line["message"] == message]


def test_a_call_is_a_line_with_peer_and_work(logged):
    said = {}

    def work(stub, process):
        said["id"] = create(stub, process)
        said["work"] = stub.Step(pb.StepRequest(session_id=said["id"], to=100_000), timeout=60).work
    steps = of(logged(work), "Step")
    for line in steps:
        assert line["session"] == said["id"] and line["code"] == "OK" and line["peer"].startswith("ipv4:127.0.0.1:")
        assert "trace_id" not in line and line["request_id"]
    assert 0 < said["work"] <= steps[0]["work"] < 2 * said["work"]


TRACES = [
    ([("traceparent", PARENT)], TRACE),
    ([("traceparent", PARENT[:-2] + "00")], TRACE),
    ([("traceparent", "cc" + PARENT[2:] + "-more")], TRACE),
    ([("traceparent", PARENT + "-more")], None),
    ([("traceparent", "ff" + PARENT[2:])], None),
    ([("traceparent", PARENT.upper())], None),
    ([("traceparent", PARENT[:-1])], None),
    ([("traceparent", "")], None),
    ([("traceparent", PARENT.replace("-", "_"))], None),
    ([("traceparent", f"00-{'0' * 32}-00f067aa0ba902b7-01")], None),
    ([("traceparent", f"00-{TRACE}-{'0' * 16}-01")], None),
    ([("traceparent", "x" * 4000)], None),
    ([("traceparent", PARENT), ("traceparent", PARENT)], None),
    ([], None)]


def test_trace_ids(logged):
    """In the trailers of unary calls and streams, and in the lines of both."""
    def work(stub, process):
        for metadata, told in TRACES:
            _, unary = stub.Describe.with_call(pb.DescribeRequest(), metadata=metadata, timeout=60)
            with pytest.raises(grpc.RpcError) as refused:
                list(stub.Stream(pb.StreamRequest(session_id="nobody"), metadata=metadata, timeout=60))
            for call in (unary, refused.value):
                assert dict(call.trailing_metadata()).get("stiefel-trace-id") == told, metadata
    lines = logged(work)
    for method in ("Describe", "Stream"):
        assert Counter(line.get("trace_id") for line in of(lines, method)) == Counter(told for _, told in TRACES)


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
        # A header holds printable ASCII only.
        stub.Describe(pb.DescribeRequest(), metadata=[("x-request-id", 'a"b\\c {"level":"error"}')], timeout=60)
    process.child.stdin.close()
    process.child.wait(60)
    lines = process.child.stderr.read().split("\n")
    assert lines.pop() == ""
    # One line a call and no more: nothing that a caller sends begins another.
    assert sum(" rpc " in line or '"rpc"' in line for line in lines) == 3 * len(HOSTILE) + 1
    if form == "json":
        objects = [json.loads(line) for line in lines]
        assert all(line["level"] in ("debug", "info", "warning") for line in objects)
        assert all(len(line.get("session", "")) <= 128 for line in objects)
        assert of(objects, "Describe")[0]["request_id"] == 'a"b\\c {"level":"error"}'
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


@pytest.mark.parametrize("method", ["CreateSession", "Stream"])
def test_a_request_that_is_no_message_has_its_line(logged, method):
    def work(stub, process):
        with grpc.insecure_channel(process.address) as channel:
            call = channel.unary_stream(f"/stiefel.v1.SimulationService/{method}")
            with pytest.raises(grpc.RpcError) as refused:
                list(call(b"\xff" * 64, timeout=60))
        assert refused.value.code() is grpc.StatusCode.INVALID_ARGUMENT
    (line,) = of(logged(work), method)
    assert line["code"] == "INVALID_ARGUMENT" and f"{method}Request" in line["error"]


def compressed(stub, number):
    """Calls that gRPC refuses with a line of its own for each."""
    for _ in range(number):
        with pytest.raises(grpc.RpcError) as refused:
            stub.ListSessions(pb.ListSessionsRequest(page_token="x" * 200), timeout=30, compression=grpc.Compression.Gzip)
        assert refused.value.code() is grpc.StatusCode.UNIMPLEMENTED


@pytest.mark.parametrize("form", ["json", "text"])
def test_grpcs_own_lines_wait_for_nobody(serve, form):
    """Six hundred such lines would fill the pipe twice; the server answers and ends in time."""
    process = serve("--log-format", form)
    with process.channel() as channel:
        stub = rpc.SimulationServiceStub(channel)
        compressed(stub, 600)
        for _ in range(2000):  # and lines of the server's own, which nobody reads either
            with pytest.raises(grpc.RpcError):
                stub.GetSession(pb.GetSessionRequest(session_id="x" * 128), timeout=10)
        assert stub.Describe(pb.DescribeRequest(), timeout=10).version
    process.child.send_signal(signal.SIGTERM)
    assert process.child.wait(20) == 0
