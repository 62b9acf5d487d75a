"""docker/grafana and docker/prometheus: Debian's Prometheus reads a live server, and every panel has data."""
import json
import re
import subprocess
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

DASHBOARD = json.loads((DOCKER / "grafana/dashboard.json").read_text(encoding="utf-8"))
RULES = DOCKER / "prometheus/rules.yaml"
QUERIES = [(panel["title"], target["expr"]) for panel in DASHBOARD["panels"] for target in panel["targets"]]
METRIC = re.compile(r"\b(?:stiefel|process)_[a-z_]+\b")

PROMTOOL = find_daemon("promtool")
needs_prometheus = pytest.mark.skipif(not PROMTOOL, reason="Debian's package prometheus is not there")


@pytest.fixture(scope="module")
def read_by_prometheus(tmp_path_factory):
    process = Process("--metrics", "127.0.0.1:0")
    url = process.child.stdout.readline().split()[-1]
    prometheus = Prometheus(tmp_path_factory.mktemp("prometheus"), [re.match(r"http://(.*)/metrics", url)[1]])
    yield process, url, prometheus
    prometheus.stop()
    process.stop()


def concrete(expression):
    """The query as Grafana sends it."""
    return expression.replace("$__rate_interval", "10s").replace("$instance", ".*")


@needs_prometheus
def test_every_panel_has_data(read_by_prometheus):
    process, _, prometheus = read_by_prometheus
    with stiefel.Client(process.address) as client, grpc.insecure_channel(process.address) as channel:
        session, stub = client.create(BODY), rpc.SimulationServiceStub(channel)
        assert eventually(lambda: prometheus.has_data("up == 1"), 60)
        missing = {expression for _, expression in QUERIES}

        def all_seen():
            # Errors and a stream, so that the panels of them have what they show.
            session.step(10)
            with pytest.raises(grpc.RpcError):
                stub.GetSession(pb.GetSessionRequest(session_id="nobody"), timeout=60)
            list(stub.Stream(pb.StreamRequest(session_id=session.id, to=100), timeout=60))
            missing.difference_update([one for one in missing if prometheus.has_data(concrete(one))])
            return not missing
        eventually(all_seen, 60)
        assert not missing


@needs_prometheus
def test_every_rule_is_evaluated(read_by_prometheus):
    _, _, prometheus = read_by_prometheus
    assert eventually(lambda: prometheus.ask("rules") is not None, 60)

    def healthy():
        rules = [rule for group in prometheus.ask("rules")["groups"] for rule in group["rules"]]
        return rules and all(rule["health"] == "ok" for rule in rules)
    assert eventually(healthy, 60)


def test_every_metric_that_is_named_is_exported(serve):
    process = serve("--metrics", "127.0.0.1:0")
    url = process.child.stdout.readline().split()[-1]
    with urllib.request.urlopen(url, timeout=60) as page:
        exported = set(re.findall(r"^([a-z_]+)", page.read().decode(), re.M))
    rules = yaml.safe_load(RULES.read_text(encoding="utf-8"))
    expressions = [expression for _, expression in QUERIES]
    expressions += [rule["expr"] for group in rules["groups"] for rule in group["rules"]]
    named = {name for expression in expressions for name in METRIC.findall(expression)}
    assert len(named) > 15 and named <= exported
    # Everything of ours is described.
    page = (DOCKER.parent / "docs/operations.md").read_text(encoding="utf-8")
    families = {re.sub("_(bucket|sum|count)$", "", name) for name in exported if name.startswith("stiefel_")}
    assert {name for name in families if f"`{name}`" not in page} == set()


@needs_prometheus
def test_promtool_takes_the_rules(tmp_path):
    for arguments in (["check", "rules", RULES], ["check", "config", DOCKER / "prometheus/prometheus.yaml"]):
        told = subprocess.run([PROMTOOL, *map(str, arguments)], capture_output=True, text=True)
        assert told.returncode == 0, told.stderr

    def series(name, values, **labels):
        text = ",".join(f'{key}="{value}"' for key, value in {"job": "stiefel", "instance": "a", **labels}.items())
        return {"series": f"{name}{{{text}}}", "values": values}

    test = {"rule_files": [str(RULES)], "evaluation_interval": "5s", "tests": [{
        "interval": "5s",
        "input_series": [series("up", "1x11 0x40"),
                         series("stiefel_calls_waiting", "3x11 15x40"), series("stiefel_threads", "2x52"),
                         series("stiefel_calls_total", "0x11 1x40", code="INTERNAL", method="Step")]}]}
    expressions = [
        ('ALERTS{alertname="StiefelServerDown",alertstate="firing"}', "50s", 0),
        ('ALERTS{alertname="StiefelServerDown",alertstate="firing"}', "90s", 1),
        ('ALERTS{alertname="StiefelOverloaded",alertstate="firing"}', "90s", 0),
        ('ALERTS{alertname="StiefelOverloaded",alertstate="firing"}', "150s", 1),
        ('ALERTS{alertname="StiefelInternalErrors",alertstate="firing"}', "50s", 0),
        ('ALERTS{alertname="StiefelInternalErrors",alertstate="firing"}', "90s", 1)]
    test["tests"][0]["promql_expr_test"] = [
        {"expr": f"count({expression}) or vector(0)", "eval_time": at,
         "exp_samples": [{"labels": "{}", "value": count}]} for expression, at, count in expressions]
    (tmp_path / "test.yaml").write_text(yaml.safe_dump(test))
    told = subprocess.run([PROMTOOL, "test", "rules", str(tmp_path / "test.yaml")], capture_output=True, text=True)
    assert told.returncode == 0, told.stdout + told.stderr
