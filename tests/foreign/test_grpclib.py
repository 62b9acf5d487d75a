"""grpclib, an HTTP/2 and a gRPC that have nothing in common with gRPC's own: every RPC."""
from __future__ import annotations

import base64
import json
import os
import subprocess
from pathlib import Path
from typing import Any

import pytest

import stiefel
import tools
from script import Call
from server_answers import Answer
from stiefel import v1 as pb

HERE = Path(__file__).parent
PROTO = HERE.parents[1] / "proto"


@pytest.fixture(scope="session")
def programs() -> Path:
    return tools.from_pypi("grpclib")


@pytest.fixture(scope="session")
def generated(programs: Path, tmp_path_factory: Any) -> Path:
    folder: Path = tmp_path_factory.mktemp("generated")
    done = subprocess.run([programs / "python", "-m", "grpc_tools.protoc", f"-I{PROTO}", f"--python_out={folder}",
                           f"--plugin=protoc-gen-grpclib_python={programs / 'protoc-gen-grpclib_python'}",
                           f"--grpclib_python_out={folder}", *sorted(PROTO.glob("stiefel/v1/*.proto"))],
                          capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return folder


def test_every_rpc(programs: Path, generated: Path, server: stiefel.Server, calls: list[Call], compare: Any) -> None:
    asked = [{"rpc": call.rpc, "requests": call.requests, "session": call.session} for call in calls]
    alone = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}  # without our package
    done = subprocess.run([programs / "python", HERE / "grpclib_client.py", *server.address.split(":"), generated],
                          input=json.dumps(asked), capture_output=True, text=True, timeout=600, env=alone)
    assert done.returncode == 0, done.stderr
    answers = []
    for call, line in zip(calls, done.stdout.splitlines()):
        said = json.loads(line)
        of_rpc = getattr(pb, f"{call.rpc}Response")
        answers.append(Answer([of_rpc.FromString(base64.b64decode(reply)) for reply in said["replies"]],
                              said["code"], said["reason"]))
    compare(calls, answers)
