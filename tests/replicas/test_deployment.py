"""What docker/ says of several servers: the files are valid, agree with each other, and do what they say."""
from __future__ import annotations

import base64
import json
import os
import re
import signal
import subprocess
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import grpc
import pytest
import yaml
from google.protobuf import descriptor_pb2

import stiefel
from cluster import ROOT, envoy_configuration, find_haproxy, free_ports, haproxy_environment, wait_for
from conftest import long
from stiefel.v1 import simulation_pb2

DOCKER = ROOT / "docker"
KUBERNETES = DOCKER / "kubernetes"
BODY = {"system": "rigid_body", "step": 0.01, "body": {"moments": [1, 2, 3], "angular_velocity": [0.1, 1, 0.2]}}


def manifests() -> dict[tuple[str, str], Any]:
    """By kind and name."""
    files = yaml.safe_load((KUBERNETES / "kustomization.yaml").read_text())["resources"]
    assert {path.name for path in KUBERNETES.glob("*.yaml")} == {*files, "kustomization.yaml"}
    every = [manifest for file in files for manifest in yaml.safe_load_all((KUBERNETES / file).read_text())]
    return {(manifest["kind"], manifest["metadata"]["name"]): manifest for manifest in every}


def pods(manifest: Any) -> Any:
    return manifest["spec"]["template"]["metadata"]["labels"]


def test_the_proxies_notice_within_30_s_that_a_client_is_gone() -> None:
    haproxy = (DOCKER / "haproxy.cfg").read_text()
    idle, interval, count = (int(re.search(rf"clitcpka-{key} (\d+)", haproxy)[1]) for key in ("idle", "intvl", "cnt"))
    assert "option clitcpka" in haproxy and idle + interval * count < 30
    binds = re.findall(r"^  bind .*", haproxy, re.M)
    assert len(binds) == 2 and all(int(re.search(r" tcp-ut (\d+)s", bind)[1]) < 30 for bind in binds)
    envoy = re.findall(r"connection_keepalive: \{interval: (\d+)s, timeout: (\d+)s\}", (DOCKER / "envoy.yaml").read_text())
    assert len(envoy) == 2 and all(int(interval) + int(timeout) < 30 for interval, timeout in envoy)


def test_the_proxies_know_the_servers_of_compose() -> None:
    compose = yaml.safe_load((DOCKER / "replicas.yaml").read_text())
    servers = sorted(name for name in compose["services"] if name != "proxy")
    assert servers == ["stiefel-1", "stiefel-2", "stiefel-3"]
    haproxy = (DOCKER / "haproxy.cfg").read_text()
    assert re.findall(r"STIEFEL_REPLICAS_\d-(stiefel-\d):50551", haproxy) == servers * 2, "for calls and for streams"
    cluster, = yaml.safe_load((DOCKER / "envoy.yaml").read_text())["static_resources"]["clusters"]
    addresses = [endpoint["endpoint"]["address"]["socket_address"] for endpoint in
                 cluster["load_assignment"]["endpoints"][0]["lb_endpoints"]]
    assert [address["address"] for address in addresses] == servers
    assert {address["port_value"] for address in addresses} == {50551}
    assert compose["networks"]["servers"] == {"internal": True}


def test_haproxy_knows_every_call_with_a_stream_of_replies() -> None:
    service = simulation_pb2.DESCRIPTOR.services_by_name["SimulationService"]
    declared = descriptor_pb2.ServiceDescriptorProto()
    service.CopyToProto(declared)
    streams = {method.name for method in declared.method if method.server_streaming}
    paths = re.search(r"use_backend streams if \{ path_end (.*) \}", (DOCKER / "haproxy.cfg").read_text())[1].split()
    assert sorted(paths) == sorted(f"/{name}" for name in streams)


def test_the_proxy_of_compose_reaches_its_server_alone(tmp_path: Path) -> None:
    """By the socket in their common volume, as the same user; the server has no network."""
    services = yaml.safe_load((DOCKER / "compose.yaml").read_text())["services"]
    server, proxy = services["stiefel"], services["proxy"]
    assert server["network_mode"] == "none" and "ports" not in server and server["user"] == proxy["user"]
    volume, = server["volumes"]
    assert volume in proxy["volumes"] and volume.endswith(":/run/stiefel")
    variables = {name: value.replace("/run/stiefel", str(tmp_path)) for name, value in proxy["environment"].items()}
    socket = f"unix:{tmp_path}/stiefel.sock"
    assert set(variables.values()) == {f"unix@{tmp_path}/stiefel.sock"}
    assert f"STIEFEL_LISTEN={socket.replace(str(tmp_path), '/run/stiefel')}" in (DOCKER / "Dockerfile").read_text()
    local, tls = free_ports(2)
    environment = {**haproxy_environment(tmp_path, [1, 2, 3], local, tls), **variables}
    with stiefel.Server.start(socket), \
            subprocess.Popen([find_haproxy(), "-db", "-f", DOCKER / "haproxy.cfg"], env=environment) as haproxy:
        try:
            wait_for(tls)
            with stiefel.Client(f"localhost:{tls}", tls=str(tmp_path / "cert.pem")) as client:
                assert client.create(BODY).step(10).step == 10
        finally:
            haproxy.terminate()


def test_kubernetes_manifests_agree() -> None:
    every = manifests()
    servers, proxies = every["Deployment", "stiefel"], every["Deployment", "stiefel-proxy"]
    for deployment in (servers, proxies):
        assert deployment["spec"]["selector"]["matchLabels"] == pods(deployment)
        for container in deployment["spec"]["template"]["spec"]["containers"]:
            assert container["securityContext"]["readOnlyRootFilesystem"] and container["resources"]["limits"]["memory"]
    for service, deployment in (("stiefel-servers", servers), ("stiefel", proxies)):
        assert every["Service", service]["spec"]["selector"] == pods(deployment)
        ports = {port["name"] for port in deployment["spec"]["template"]["spec"]["containers"][0]["ports"]}
        assert {port["targetPort"] for port in every["Service", service]["spec"]["ports"]} <= ports
    assert every["Service", "stiefel-servers"]["spec"]["clusterIP"] == "None", "headless"
    for name, deployment in (("stiefel", servers), ("stiefel-proxy", proxies)):
        assert every["PodDisruptionBudget", name]["spec"]["selector"]["matchLabels"] == pods(deployment)
    policy = every["NetworkPolicy", "stiefel"]["spec"]
    assert policy["podSelector"]["matchLabels"] == pods(servers)
    assert policy["ingress"][0]["from"] == [{"podSelector": {"matchLabels": pods(proxies)}}]
    scaler = every["HorizontalPodAutoscaler", "stiefel"]["spec"]
    assert scaler["scaleTargetRef"]["name"] == "stiefel" and "replicas" not in servers["spec"]
    assert scaler["metrics"][0]["pods"]["metric"]["name"] == "stiefel_calls_waiting"
    pod = servers["spec"]["template"]["spec"]
    environment = {entry["name"]: entry.get("value") for entry in pod["containers"][0]["env"]}
    assert pod["terminationGracePeriodSeconds"] > float(environment["STIEFEL_GRACE"]) + 2


def test_prometheus_finds_the_servers_of_kubernetes() -> None:
    """By the label and the port of their pods, and under the job that the rules and the dashboard name."""
    job, = yaml.safe_load((DOCKER / "prometheus/kubernetes.yaml").read_text())["scrape_configs"]
    label, port = job["relabel_configs"][0]["regex"].split(";")
    servers = manifests()["Deployment", "stiefel"]
    container, = servers["spec"]["template"]["spec"]["containers"]
    assert pods(servers) == {"app": label} and port in {one["name"] for one in container["ports"]}
    environment = {entry["name"]: entry.get("value") for entry in container["env"]}
    number, = [one["containerPort"] for one in container["ports"] if one["name"] == port]
    assert environment["STIEFEL_METRICS"].endswith(f":{number}")
    named = re.findall(r'job="(\w+)"', (DOCKER / "prometheus/rules.yaml").read_text())
    assert {job["job_name"], *named} == {"stiefel"}


def flags_of(container: Any) -> dict[str, str]:
    """The variables of a server's container."""
    return {entry["name"]: entry.get("value", "2") for entry in container["env"]}


@pytest.mark.parametrize("given", ["kubernetes", "replicas.yaml", "compose.yaml", "stiefel.service", "Dockerfile"])
def test_the_flags_of_each_deployment_are_sound(given: str, tmp_path: Path) -> None:
    """Every variable is one of the server, and `check` takes their values."""
    if given == "kubernetes":
        variables = flags_of(manifests()["Deployment", "stiefel"]["spec"]["template"]["spec"]["containers"][0])
    elif given.endswith(".yaml"):
        service = next(iter(yaml.safe_load((DOCKER / given).read_text())["services"].values()))
        variables = service.get("environment", {})
    else:
        variables = dict(re.findall(r"(STIEFEL_\w+)=(\S+)", "\n".join(
            line for line in (DOCKER / given).read_text().splitlines() if re.match(r"(ENV|Environment=)", line))))
    assert variables or given == "compose.yaml"
    for name, value in variables.items():
        variables[name] = variables[name].replace("/run/stiefel/", f"{tmp_path}/")
    server = os.environ["STIEFEL_SERVER"]
    known = subprocess.run([server, "flags"], capture_output=True, text=True, check=True).stdout
    assert set(variables) <= set(re.findall(r"`(STIEFEL_\w+)`", known))
    checked = subprocess.run([server, "check"], env={**os.environ, **variables}, capture_output=True, text=True)
    assert checked.returncode == 0, checked.stderr


def test_envoy_in_kubernetes_finds_the_headless_service(tmp_path: Path) -> None:
    command = next(line.lstrip("# ") for line in (KUBERNETES / "kustomization.yaml").read_text().splitlines() if "sed" in line)
    made = subprocess.run(["sh", "-c", command.replace("> /tmp/envoy.yaml", "")], cwd=ROOT, capture_output=True, text=True, check=True)
    cluster, = yaml.safe_load(made.stdout)["static_resources"]["clusters"]
    endpoint, = cluster["load_assignment"]["endpoints"][0]["lb_endpoints"]
    assert endpoint["endpoint"]["address"]["socket_address"] == {"address": "stiefel-servers", "port_value": 50551}
    assert ("Service", "stiefel-servers") in manifests()


def test_a_server_that_is_told_to_stop_loses_no_call(make_cluster: Any) -> None:
    """It finishes what runs, refuses what is new, and answers the proxy's health check with NOT_SERVING."""
    cluster = make_cluster("haproxy")
    with stiefel.Client(cluster.address) as client:
        sessions = [client.create(BODY) for _ in range(12)]
        expected = [session.step(50) for session in sessions]
        replica = cluster.replicas[0]
        replica.child.send_signal(signal.SIGTERM)
        end, calls = time.monotonic() + 3, 0
        while time.monotonic() < end:
            for session, state in zip(sessions, expected):
                assert session.step(50) == state
                calls += 1
        assert calls > 100
        replica.child.wait(30)
        replica.start()
        wait_for(replica.port)


@pytest.mark.parametrize("proxy", ["haproxy", pytest.param("envoy", marks=long)])
def test_a_server_that_answers_late_keeps_its_sessions(proxy: str, make_cluster: Any) -> None:
    """One that has no processor for 2 s is not gone: its calls wait, and none goes to a server without the session."""
    cluster = make_cluster(proxy)
    with stiefel.Client(cluster.address) as client:
        ids = [client.create(BODY).id for _ in range(12)]
        assert all(client.get(id).step(50).step == 50 for id in ids)
        late = cluster.replicas[0].child
        late.send_signal(signal.SIGSTOP)
        threading.Timer(2, late.send_signal, [signal.SIGCONT]).start()
        end = time.monotonic() + 4
        while time.monotonic() < end:
            with ThreadPoolExecutor(len(ids)) as pool:
                assert {state.step for state in pool.map(lambda id: client.get(id).step(50), ids)} == {50}


@long
def test_kubernetes_takes_the_manifests(peers: Path) -> None:
    for file in yaml.safe_load((KUBERNETES / "kustomization.yaml").read_text())["resources"]:
        done = subprocess.run([peers / "kubernetes-validate", "--strict", KUBERNETES / file], capture_output=True, text=True)
        assert done.returncode == 0, done.stdout + done.stderr


@long
def test_envoy_tells_the_errors_of_a_stream_over_http_1(make_cluster: Any, tmp_path: Path) -> None:
    """In the trailers, whether it has begun or not."""
    cluster = make_cluster("envoy")

    def trailers(session: str, rpc: str = "Stream", **request: Any) -> str:
        done = subprocess.run(
            ["curl", "-sS", "--http1.1", "--cacert", tmp_path / "cert.pem", "-D", "-", "-o", tmp_path / "body",
             "-H", "content-type: application/json", "-H", f"stiefel-session: {session}", "-H", "grpc-timeout: 500m",
             "-d", json.dumps({"session_id": session, **request}),
             f"https://localhost:{cluster.tls}/stiefel.v1.SimulationService/{rpc}"], capture_output=True, text=True, check=True)
        return done.stdout.split("\n\n" if "\r" not in done.stdout else "\r\n\r\n", 1)[1]
    trailers("s", "CreateSession", scene=BODY)
    assert "grpc-status: 5" in trailers("nobody", to=1) and "grpc-message: session_id: nobody" in trailers("nobody", to=1)
    begun = trailers("s", to=10**9, every=10**6)
    assert "grpc-status: 4" in begun and b"steps" in (tmp_path / "body").read_bytes()


@long
def test_envoy_speaks_grpc_web(make_cluster: Any, tmp_path: Path) -> None:
    """Describe with an empty message, in the encoding that browsers send."""
    cluster = make_cluster("envoy")
    done = subprocess.run(["curl", "-sS", "--cacert", tmp_path / "cert.pem", "-H", "content-type: application/grpc-web-text",
                           "-H", "accept: application/grpc-web-text", "-d", base64.b64encode(bytes(5)).decode(),
                           f"https://localhost:{cluster.tls}/stiefel.v1.SimulationService/Describe"], capture_output=True, check=True)
    frame = base64.b64decode(done.stdout[:8])
    assert frame[0] == 0 and int.from_bytes(frame[1:5], "big") > 1000, "the length of a DescribeResponse"


@long
def test_envoy_refuses_what_is_too_much(make_cluster: Any, tmp_path: Path, peers: Path) -> None:
    cluster = make_cluster("envoy")
    folder = tmp_path / "limited"
    folder.mkdir()
    local, tls = free_ports(2)
    configuration = envoy_configuration(folder, [replica.port for replica in cluster.replicas], local, tls, calls_a_second=5)
    with subprocess.Popen([peers / "envoy", "-c", configuration, "--use-dynamic-base-id", "--log-level", "off"]) as envoy:
        try:
            wait_for(local)
            time.sleep(1)
            with grpc.insecure_channel(f"127.0.0.1:{local}") as channel:
                describe = stiefel.v1.simulation_pb2_grpc.SimulationServiceStub(channel).Describe
                codes = set()
                for _ in range(40):
                    try:
                        describe(stiefel.v1.DescribeRequest())
                    except grpc.RpcError as error:
                        codes.add(error.code())
            assert codes == {grpc.StatusCode.RESOURCE_EXHAUSTED}
        finally:
            envoy.terminate()
