"""grpcurl: every RPC by the server's reflection, without a file of the protocol."""
from __future__ import annotations

import json
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import grpc
import pytest

import stiefel
import tools
from script import Call
from server_answers import Answer, detail_of, reason_in, reply_of

SERVICE = "stiefel.v1.SimulationService"


@pytest.fixture(scope="session")
def grpcurl() -> Path:
    return tools.from_go("grpcurl")


def documents(text: str) -> Iterator[Any]:
    """JSON values one after another."""
    decoder, at = json.JSONDecoder(), 0
    while at < len(text.rstrip()):
        value, at = decoder.raw_decode(text, at)
        yield value
        at += len(text) - at - len(text[at:].lstrip())


def call_by(grpcurl: Path, address: str, call: Call) -> Answer:
    session = ["-H", f"stiefel-session: {call.session}"] if call.session else []
    done = subprocess.run([grpcurl, "-plaintext", "-format-error", *session, "-d", "@", address, f"{SERVICE}/{call.rpc}"],
                          input="\n".join(map(json.dumps, call.requests)), capture_output=True, text=True, timeout=300)
    replies = [reply_of(call.rpc, value) for value in documents(done.stdout)]
    if done.returncode == 0:
        return Answer(replies)
    error = next(documents(done.stderr[done.stderr.index("{"):]))
    reason = reason_in(map(detail_of, error.get("details", [])))
    code = next(code.name for code in grpc.StatusCode if code.value[0] == error["code"])
    assert done.returncode == 64 + error["code"]
    return Answer(replies, code, reason)


def test_every_rpc(grpcurl: Path, server: stiefel.Server, calls: list[Call], compare: Any) -> None:
    compare(calls, [call_by(grpcurl, server.address, call) for call in calls])


def test_the_service_is_listed_and_described(grpcurl: Path, server: stiefel.Server) -> None:
    def ask(*arguments: str) -> str:
        return subprocess.run([grpcurl, "-plaintext", server.address, *arguments], capture_output=True, text=True, check=True).stdout
    listed = ask("list", SERVICE).split()
    declared = stiefel.v1.simulation_pb2.DESCRIPTOR.services_by_name["SimulationService"].methods
    assert sorted(listed) == sorted(f"{SERVICE}.{method.name}" for method in declared)
    assert "rpc Step ( .stiefel.v1.StepRequest )" in ask("describe", SERVICE)
