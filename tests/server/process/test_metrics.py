"""What a server tells Prometheus over HTTP: of calls that were made over gRPC, to whom, and what dashboard and rules read."""
import json
import os
import re
import socket
import subprocess
import threading
import time
import urllib.request

import grpc
import pytest
import yaml

import stiefel
from conftest import BODY, Process, eventually
from daemons import find_daemon
from prometheus import DOCKER, Prometheus
from stiefel import v1 as pb
from stiefel.v1 import simulation_pb2_grpc as rpc

SAMPLE = re.compile(r'^([a-z_]+)(?:\{(.*)\})? (\S+)$')


def read(url):
    """{(name, (label, value), ...): value} of every sample."""
    samples = {}
    with urllib.request.urlopen(url, timeout=60) as page:
        for line in page.read().decode().splitlines():
            if line and not line.startswith("#"):
                name, labels, value = SAMPLE.match(line).groups()
                pairs = tuple(sorted(re.findall(r'(\w+)="([^"]*)"', labels or "")))
                samples[(name, *pairs)] = float(value)
    return samples


class Metered:
    """A server with metrics; `url` is where."""

    def __init__(self, process):
        self.process, self.address = process, process.address
        line = process.child.stdout.readline()
        assert line.startswith("metrics at http"), line
        self.url = line.split()[-1]
        self.port = int(self.url.split(":")[2].partition("/")[0])

    def value(self, name, **labels):
        return read(self.url).get((name, *sorted(labels.items())))

    def answer(self, request):
        """What it answers to these bytes of HTTP."""
        with socket.create_connection(("127.0.0.1", self.port), timeout=60) as connection:
            connection.sendall(request)
            return connection.makefile("rb").read()


@pytest.fixture
def metered(serve):
    return lambda *arguments, at="127.0.0.1:0": Metered(serve("--metrics", at, *arguments))


def test_calls_and_what_the_server_holds(metered):
    server = metered("--threads", "2", "--max-sessions", "7")
    with stiefel.Client(server.address) as client, grpc.insecure_channel(server.address) as channel:
        stub, sessions = rpc.SimulationServiceStub(channel), [client.create(BODY) for _ in range(3)]
        version = client.describe().version
        for to in (0, 1, 2, 3, 200_000):
            sessions[0].step(to)
        for _ in range(3):
            with pytest.raises(grpc.RpcError):
                stub.GetSession(pb.GetSessionRequest(session_id="nobody"), timeout=60)
        seen = read(server.url)
        calls = lambda method, code: seen[("stiefel_calls_total", ("code", code), ("method", method))]
        assert calls("CreateSession", "OK") == 3 and calls("Step", "OK") == 5 and calls("Step", "INTERNAL") == 0
        assert calls("GetSession", "NOT_FOUND") == 3
        assert seen[("stiefel_refusals_total", ("reason", "SESSION_NOT_FOUND"))] == 3
        assert seen[("stiefel_call_seconds_count", ("method", "Step"))] == 5
        assert 0 < seen[("stiefel_call_seconds_sum", ("method", "Step"))] < 10
        buckets = [value for key, value in seen.items()
                   if key[0] == "stiefel_call_seconds_bucket" and ("method", "Step") in key]
        assert buckets == sorted(buckets) and buckets[-1] == 5
        methods = {dict(key[1:])["method"] for key in seen if key[0] == "stiefel_calls_total"}
        assert methods == {method.name for method in
                           pb.simulation_pb2.DESCRIPTOR.services_by_name["SimulationService"].methods}
        assert seen[("stiefel_sessions",)] == 3 and seen[("stiefel_sessions_limit",)] == 7
        assert seen[("stiefel_threads",)] == 2 and seen[("stiefel_calls_waiting",)] == 0
        assert 0 < seen[("stiefel_memory_bytes",)] < seen[("stiefel_memory_limit_bytes",)]
        # 200 000 steps of a tenth of a microsecond or more.
        assert seen[("stiefel_computing_seconds_total",)] > 0.02 and seen[("process_cpu_seconds_total",)] > 0.02
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
            stub.CreateSession(pb.CreateSessionRequest(session_id="second", scene=stiefel.to_message(BODY)), timeout=60)
        assert server.value("stiefel_refusals_total", reason="TOO_MANY_SESSIONS") == 1


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


def test_only_the_metrics_are_served(metered):
    server = metered()
    for path in ("/", "/etc/passwd", "/../../etc/passwd"):
        assert server.answer(f"GET {path} HTTP/1.1\r\nhost: a\r\n\r\n".encode()).startswith(b"HTTP/1.1 404"), path
    for data in (b"POST /metrics HTTP/1.1\r\nhost: a\r\ncontent-length: 0\r\n\r\n", b"\x16\x03\x01\x02\x00", b"\0" * 100,
                 b"GET /" + b"m" * 100_000 + b" HTTP/1.1\r\n\r\n"):
        try:
            assert b"stiefel_threads" not in server.answer(data)
        except OSError:  # it hung up while the request was sent
            pass
    assert server.value("stiefel_threads") >= 1


def test_a_reader_that_does_not_read_holds_up_nobody(metered):
    server, lazy = metered(), []
    for _ in range(15):
        lazy.append(socket.create_connection(("127.0.0.1", server.port)))
        lazy[-1].setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1)
        lazy[-1].sendall(b"GET /metrics HTTP/1.1\r\nhost: a\r\n\r\n")
    for _ in range(3):
        assert server.value("stiefel_threads") >= 1
    for connection in lazy:
        connection.close()


@pytest.mark.parametrize("address, rule", [
    ("0.0.0.0:0", "other machines can reach it"), ("0:0", "other machines can reach it"), ("unix:/tmp/metrics", "must be host:port"),
    ("[::1]:0", "must be host:port"), ("127.0.0.1", "has no port")])
def test_where_metrics_are_not_served(address, rule):
    for arguments in (["check", "--metrics", address], ["--listen", "127.0.0.1:0", "--metrics", address]):
        told = subprocess.run([os.environ["STIEFEL_SERVER"], *arguments], capture_output=True, text=True, timeout=60)
        assert told.returncode != 0 and address in told.stderr and rule in told.stderr


def test_where_they_are(metered, serve):
    assert metered(at="localhost:0").url.startswith("http://localhost:")
    assert read(metered("--insecure", at="0.0.0.0:0").url.replace("0.0.0.0", "127.0.0.1"))[("stiefel_threads",)] >= 1
    taken = f"127.0.0.1:{metered().port}"
    told = subprocess.run([os.environ["STIEFEL_SERVER"], "--listen", "127.0.0.1:0", "--metrics", taken],
                          capture_output=True, text=True, timeout=60)
    assert told.returncode == 1 and taken in told.stderr
    without = serve()
    assert without.stop() == 0 and "metrics" not in without.child.stdout.read()


DASHBOARD = json.loads((DOCKER / "grafana/dashboard.json").read_text(encoding="utf-8"))
RULES = DOCKER / "prometheus/rules.yaml"
QUERIES = [target["expr"] for panel in DASHBOARD["panels"] for target in panel["targets"]]
PROMTOOL = find_daemon("promtool")
needs_prometheus = pytest.mark.skipif(not PROMTOOL, reason="Debian's package prometheus is not there")


def test_every_metric_that_is_named_is_exported(metered):
    exported = {key[0] for key in read(metered().url)}
    rules = yaml.safe_load(RULES.read_text(encoding="utf-8"))
    expressions = QUERIES + [rule["expr"] for group in rules["groups"] for rule in group["rules"]]
    named = {name for one in expressions for name in re.findall(r"\b(?:stiefel|process)_[a-z_]+\b", one)}
    assert len(named) > 12 and named <= exported
    # Everything of ours is described.
    page = (DOCKER.parent / "docs/operations.md").read_text(encoding="utf-8")
    families = {re.sub("_(bucket|sum|count)$", "", name) for name in exported if name.startswith("stiefel_")}
    assert {name for name in families if f"`{name}`" not in page} == set()


@needs_prometheus
def test_every_panel_has_data_and_every_rule_is_evaluated(tmp_path):
    server = Metered(Process("--metrics", "127.0.0.1:0"))
    prometheus = Prometheus(tmp_path, [f"127.0.0.1:{server.port}"])
    try:
        with stiefel.Client(server.address) as client:
            session = client.create(BODY)
            assert eventually(lambda: prometheus.has_data("up == 1"), 60)
            missing = set(QUERIES)

            def all_seen():
                # Errors too, so that the panels of them have what they show.
                session.step(10)
                with pytest.raises(stiefel.NotFound):
                    client.get("nobody")
                missing.difference_update([one for one in missing if prometheus.has_data(
                    one.replace("$__rate_interval", "10s").replace("$instance", ".*"))])
                return not missing
            eventually(all_seen, 60)
            assert not missing

        def healthy():
            rules = [rule for group in prometheus.ask("rules")["groups"] for rule in group["rules"]]
            return rules and all(rule["health"] == "ok" for rule in rules)
        assert eventually(healthy, 60)
    finally:
        prometheus.stop()
        server.process.stop()


@needs_prometheus
def test_promtool_takes_the_rules(tmp_path):
    for arguments in (["check", "rules", RULES], ["check", "config", DOCKER / "prometheus/prometheus.yaml"]):
        told = subprocess.run([PROMTOOL, *map(str, arguments)], capture_output=True, text=True)
        assert told.returncode == 0, told.stderr

    def series(name, values, **labels):
        text = ",".join(f'{key}="{value}"' for key, value in {"job": "stiefel", "instance": "a", **labels}.items())
        return {"series": f"{name}{{{text}}}", "values": values}
    firing = [("StiefelServerDown", "50s", 0), ("StiefelServerDown", "90s", 1), ("StiefelOverloaded", "90s", 0),
              ("StiefelOverloaded", "150s", 1), ("StiefelInternalErrors", "50s", 0), ("StiefelInternalErrors", "90s", 1)]
    test = {"rule_files": [str(RULES)], "evaluation_interval": "5s", "tests": [{
        "interval": "5s",
        "input_series": [series("up", "1x11 0x40"),
                         series("stiefel_calls_waiting", "3x11 15x40"), series("stiefel_threads", "2x52"),
                         series("stiefel_calls_total", "0x11 1x40", code="INTERNAL", method="Step")],
        "promql_expr_test": [{"expr": f'count(ALERTS{{alertname="{name}",alertstate="firing"}}) or vector(0)', "eval_time": at,
                              "exp_samples": [{"labels": "{}", "value": count}]} for name, at, count in firing]}]}
    (tmp_path / "test.yaml").write_text(yaml.safe_dump(test))
    told = subprocess.run([PROMTOOL, "test", "rules", str(tmp_path / "test.yaml")], capture_output=True, text=True)
    assert told.returncode == 0, told.stdout + told.stderr
