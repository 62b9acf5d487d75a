"""JSON over HTTP through Envoy, by curl: what docs/operations.md shows, and every RPC but Drive."""
from __future__ import annotations

import base64
import json
import math
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import grpc
import pytest

import stiefel
import tools
from exchange import STREAMS, Answer, Call, calls, compare, reason_in
from google.protobuf import json_format
from stiefel import v1 as pb

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "tests/replicas"))
from cluster import envoy_configuration, free_ports, wait_for  # noqa: E402

HTTP = {"INVALID_ARGUMENT": 400, "NOT_FOUND": 404, "ALREADY_EXISTS": 409}


@dataclass
class Proxy:
    folder: Path
    tls: int


@pytest.fixture(scope="module")
def envoy(server: stiefel.Server, tmp_path_factory: Any) -> Iterator[Proxy]:
    """docker/envoy.yaml, with one server in the place of three."""
    program = tools.from_pypi("envoy") / "envoy"
    if not shutil.which("curl"):
        pytest.skip("there is no program curl")
    folder: Path = tmp_path_factory.mktemp("envoy")
    local, tls = free_ports(2)
    port = int(server.address.rsplit(":", 1)[1])
    configuration = envoy_configuration(folder, [port] * 3, local, tls)
    with subprocess.Popen([program, "-c", configuration, "--use-dynamic-base-id", "--log-level", "warn"],
                          stdout=(folder / "log").open("w"), stderr=subprocess.STDOUT) as child:
        try:
            wait_for(tls)
            while b"grpc-status" not in curl(Proxy(folder, tls), "Describe", {})[0]:
                assert child.poll() is None, (folder / "log").read_text()
            yield Proxy(folder, tls)
        finally:
            child.terminate()


def curl(envoy: Proxy, rpc: str, request: Any, session: str = "none") -> tuple[bytes, bytes]:
    """Headers and body."""
    headers = envoy.folder / "headers"
    done = subprocess.run(["curl", "-sS", "--cacert", envoy.folder / "cert.pem", "-H", "content-type: application/json",
                           "-H", f"stiefel-session: {session}", "-d", "@-", "-D", headers,
                           f"https://localhost:{envoy.tls}/stiefel.v1.SimulationService/{rpc}"],
                          input=json.dumps(request).encode(), capture_output=True, timeout=300)
    assert done.returncode == 0, done.stderr
    return headers.read_bytes(), done.stdout


def call_by(envoy: Proxy, call: Call) -> Answer:
    """A stream's replies are an array. An error is HTTP's status and gRPC's headers, of a stream 200; its details are in
    HTTP/2's trailers."""
    head, body = curl(envoy, call.rpc, call.requests[0], call.session)
    status, *lines = head.decode().replace("\r", "").strip().splitlines()
    headers = dict(line.split(": ", 1) for line in lines if line)
    if headers.get("grpc-status", "0") == "0":
        assert status.split()[1] == "200"
        said = json.loads(body)
        kind = getattr(pb, f"{call.rpc}Response")
        return Answer([json_format.ParseDict(one, kind()) for one in (said if call.rpc in STREAMS else [said])])
    packed = headers["grpc-status-details-bin"]
    error = pb.Status.FromString(base64.b64decode(packed + "=" * (-len(packed) % 4)))
    code = next(code.name for code in grpc.StatusCode if code.value[0] == error.code)
    streams = call.rpc in STREAMS
    assert status.split()[1] == ("200" if streams else str(HTTP[code])) and headers["grpc-status"] == str(error.code)
    assert unquote(headers["grpc-message"]) == error.message and body == (b"[]" if streams else b"")
    return Answer([], code, reason_in(error.details))


def test_every_rpc_but_drive(envoy: Proxy) -> None:
    by_json = [call for call in calls() if call.rpc != "Drive"]
    compare(by_json, [call_by(envoy, call) for call in by_json])


def test_the_lines_of_the_documentation(envoy: Proxy) -> None:
    """Every unary RPC is among them; each line is run as it stands, but for the name of the proxy."""
    text = (ROOT / "docs/operations.md").read_text().split("<!-- curl -->")[1]
    script = re.search(r"```sh\n(.*?)```", text, re.DOTALL).group(1)  # type: ignore[union-attr]
    service = stiefel.v1.simulation_pb2.DESCRIPTOR.services_by_name["SimulationService"]
    unary = {method.name for method in service.methods if method.name not in STREAMS}
    lines = re.findall(r"^call (\w+)", script, re.MULTILINE)
    assert unary <= set(lines)
    script = script.replace("stiefel.example:50551", f"localhost:{envoy.tls}").replace("ca.pem", str(envoy.folder / "cert.pem"))
    done = subprocess.run(["bash", "-e"], input=re.sub(r"^(call .*)$", r"\1; echo; echo ---", script, flags=re.MULTILINE),
                          capture_output=True, text=True, env={**os.environ, "LC_ALL": "C"}, timeout=60)
    assert done.returncode == 0, done.stderr + done.stdout
    replies = [json.loads(one) for one in done.stdout.split("---\n") if one.strip()]
    assert len(replies) == len(lines)
    said = dict(zip(lines, replies))
    assert said["Describe"]["limits"]["max_dimension"] == 1024
    assert said["CreateSession"]["created"] and said["ForkSession"]["created"]
    assert said["Step"]["sample"]["step"] == "100" and said["Step"]["run_status"] == {"outcome": "OUTCOME_REACHED"}
    assert said["Diagnose"]["invariants"][0]["drift"] < 1e-12
    assert said["Convert"]["blocks"][0]["name"] == "Q" and abs(said["ConjugatePoints"]["points"][0]["time"] - math.pi) < 1e-9
    assert len(said["Stream"][0]["steps"]) > 0
