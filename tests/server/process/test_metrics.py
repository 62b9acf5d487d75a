"""What a server tells Prometheus, over HTTP, of calls that were made over gRPC."""
import threading
import time

import grpc
import pytest

import stiefel
from conftest import BODY, eventually
from metered import Metered, read
from stiefel import v1 as pb
from stiefel.v1 import simulation_pb2_grpc as rpc


@pytest.fixture
def metered(serve):
    return lambda *arguments: Metered(serve("--metrics", "127.0.0.1:0", *arguments))


def test_calls_are_counted_by_method_and_code(metered):
    server = metered()
    with stiefel.Client(server.address) as client:
        session = client.create(BODY)
        for to in range(5):
            session.step(to)
    with grpc.insecure_channel(server.address) as channel:
        stub = rpc.SimulationServiceStub(channel)
        for _ in range(3):
            with pytest.raises(grpc.RpcError):
                stub.GetSession(pb.GetSessionRequest(session_id="nobody"), timeout=60)
    seen = read(server.url)
    calls = lambda method, code: seen[("stiefel_calls_total", ("code", code), ("method", method))]
    assert calls("CreateSession", "OK") == 1 and calls("Step", "OK") == 5 and calls("Step", "INTERNAL") == 0
    assert calls("GetSession", "NOT_FOUND") == 3
    assert seen[("stiefel_refusals_total", ("reason", "SESSION_NOT_FOUND"))] == 3
    assert seen[("stiefel_call_seconds_count", ("method", "Step"))] == 5
    assert 0 < seen[("stiefel_call_seconds_sum", ("method", "Step"))] < 10
    assert seen[("stiefel_calls_running", ("method", "Step"))] == 0
    buckets = [value for key, value in seen.items()
               if key[0] == "stiefel_call_seconds_bucket" and ("method", "Step") in key]
    assert buckets == sorted(buckets) and buckets[-1] == 5
    # Every RPC of the service is there.
    methods = {dict(key[1:])["method"] for key in seen if key[0] == "stiefel_calls_total"}
    assert methods == {method.name for method in
                       pb.simulation_pb2.DESCRIPTOR.services_by_name["SimulationService"].methods}


def test_what_the_server_holds(metered):
    server = metered("--threads", "2", "--max-sessions", "7")
    with stiefel.Client(server.address) as client:
        sessions = [client.create(BODY) for _ in range(3)]
        version = client.describe().version
        sessions[0].step(200_000)
        seen = read(server.url)
        assert seen[("stiefel_sessions",)] == 3 and seen[("stiefel_sessions_limit",)] == 7
        assert seen[("stiefel_threads",)] == 2
        assert 0 < seen[("stiefel_memory_bytes",)] < seen[("stiefel_memory_limit_bytes",)]
        # 200 000 steps of a tenth of a microsecond or more.
        assert seen[("stiefel_computing_seconds_total",)] > 0.02
        assert seen[("stiefel_calls_waiting",)] == 0
        build = next(key for key in seen if key[0] == "stiefel_build_info")
        assert dict(build[1:])["version"] == version and len(dict(build[1:])["numerics_id"]) > 8
        assert seen[("process_resident_memory_bytes",)] > 1e6 and seen[("process_open_fds",)] > 5
        assert abs(seen[("process_start_time_seconds",)] - time.time()) < 600
        sessions[1].delete()
    assert server.value("stiefel_sessions") == 2


def test_waiting_calls_are_seen_and_go(metered):
    server = metered("--threads", "1")
    with stiefel.Client(server.address) as client, grpc.insecure_channel(server.address) as channel:
        stub = rpc.SimulationServiceStub(channel)
        sessions = [client.create(BODY) for _ in range(4)]
        calls = [stub.Step.future(pb.StepRequest(session_id=session.id, to=2_000_000_000)) for session in sessions]
        assert eventually(lambda: server.value("stiefel_calls_waiting") == 3)
        assert server.value("stiefel_calls_running", method="Step") == 4
        for call in calls:
            call.cancel()
        assert eventually(lambda: server.value("stiefel_calls_running", method="Step") == 0)
        assert server.value("stiefel_calls_waiting") == 0
        assert server.value("stiefel_calls_total", method="Step", code="CANCELLED") == 4


def test_a_reader_that_does_not_read_is_behind(metered):
    server = metered()
    with stiefel.Client(server.address) as client, grpc.insecure_channel(server.address) as channel:
        session = client.create(BODY)
        stream = rpc.SimulationServiceStub(channel).Stream(
            pb.StreamRequest(session_id=session.id, to=10_000_000), timeout=120)
        next(stream)
        assert eventually(lambda: server.value("stiefel_streams_behind") == 1)
        assert server.value("stiefel_streams_open") == 1
        assert eventually(lambda: server.value("stiefel_stream_lag_seconds") > 0.1)
        stream.cancel()
        assert eventually(lambda: server.value("stiefel_streams_open") == 0)
        assert server.value("stiefel_stream_lag_seconds") == 0


def test_refusals_name_the_limit_inside_a_drive_too(metered):
    server = metered("--max-call-seconds", "0.01", "--max-sessions", "1")
    with stiefel.Client(server.address) as client, grpc.insecure_channel(server.address) as channel:
        stub, session = rpc.SimulationServiceStub(channel), client.create(BODY)
        with pytest.raises(grpc.RpcError):
            stub.Step(pb.StepRequest(session_id=session.id, to=10**9), timeout=60)
        reply = next(stub.Drive(iter([pb.DriveRequest(session_id=session.id, to=10**9)]), timeout=60))
        assert reply.error.code == grpc.StatusCode.RESOURCE_EXHAUSTED.value[0]
        assert server.value("stiefel_refusals_total", reason="OVER_QUOTA", limit="call_seconds") == 2
        with pytest.raises(grpc.RpcError):
            stub.Step(pb.StepRequest(session_id=session.id, to=-1), timeout=60)
        assert server.value("stiefel_refusals_total", reason="INVALID_ARGUMENT") == 1
        with pytest.raises(grpc.RpcError):
            request = pb.CreateSessionRequest(session_id="second")
            request.scene.CopyFrom(stub.GetSession(
                pb.GetSessionRequest(session_id=session.id, view=pb.SessionView(scene=pb.SCENE_VIEW_FULL)), timeout=60).session.scene)
            stub.CreateSession(request, timeout=60)
        assert server.value("stiefel_refusals_total", reason="TOO_MANY_SESSIONS") == 1


def test_a_refused_token_is_counted(serve, tmp_path):
    (tmp_path / "tokens").write_text("")
    server = Metered(serve("--metrics", "127.0.0.1:0", "--tokens", str(tmp_path / "tokens")))
    with grpc.insecure_channel(server.address) as channel, pytest.raises(grpc.RpcError):
        rpc.SimulationServiceStub(channel).Describe(pb.DescribeRequest(), timeout=60)
    assert server.value("stiefel_calls_total", method="Describe", code="UNAUTHENTICATED") == 1
    assert server.value("stiefel_refusals_total", reason="TOKEN_MISSING") == 1


def test_readers_at_once_with_calls(metered):
    """Scrapes while calls begin and end: no sample is torn, and no count is negative or falls."""
    server, stop, faults = metered(), threading.Event(), []

    def scrape():
        last = 0
        while not stop.is_set():
            seen = read(server.url)
            count = seen[("stiefel_calls_total", ("code", "OK"), ("method", "Step"))]
            running = seen[("stiefel_calls_running", ("method", "Step"))]
            if count < last or not 0 <= running <= 2:
                faults.append((count, last, running))
            last = count
    scrapers = [threading.Thread(target=scrape) for _ in range(3)]
    with stiefel.Client(server.address) as client:
        session = client.create(BODY)
        for scraper in scrapers:
            scraper.start()
        for to in range(500):
            session.step(to % 50)
        stop.set()
        for scraper in scrapers:
            scraper.join()
    assert faults == []
    assert server.value("stiefel_calls_total", method="Step", code="OK") == 500
