"""grpc-js, whose largest message is 4 MiB unless told otherwise: every RPC; what is larger comes by Stream in parts."""
from __future__ import annotations

import base64
import json
import subprocess
from pathlib import Path
from typing import Any

import grpc
import pytest

import stiefel
import tools
from script import Call
from server_answers import Answer, reason_of, reply_of

HERE = Path(__file__).parent
PROTO = HERE.parents[1] / "proto"


@pytest.fixture(scope="session")
def modules() -> Path:
    return tools.from_npm()


def as_protobuf_writes_it(value: Any) -> Any:
    """proto-loader has no special form of times and durations: they are {seconds, nanos}."""
    if isinstance(value, dict):
        if value and value.keys() <= {"seconds", "nanos"}:
            return f"{value.get('seconds', 0)}.{value.get('nanos', 0):09d}s"
        return {key: as_protobuf_writes_it(each) for key, each in value.items()
                if key not in ("create_time", "expire_time")}
    return [as_protobuf_writes_it(each) for each in value] if isinstance(value, list) else value


def test_every_rpc(modules: Path, server: stiefel.Server, calls: list[Call], compare: Any) -> None:
    asked = [{"rpc": call.rpc, "requests": call.requests, "session": call.session} for call in calls]
    done = subprocess.run(["node", HERE / "grpc_js.js", server.address, PROTO, modules], input=json.dumps(asked),
                          capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stderr
    answers = []
    for call, line in zip(calls, done.stdout.splitlines()):
        said = json.loads(line)
        answer = Answer([reply_of(call.rpc, as_protobuf_writes_it(reply)) for reply in said["replies"]])
        if "code" in said:
            answer.code = next(code.name for code in grpc.StatusCode if code.value[0] == said["code"])
            answer.reason = reason_of(base64.b64decode(said["details"]))
        answers.append(answer)
    compare(calls, answers)
