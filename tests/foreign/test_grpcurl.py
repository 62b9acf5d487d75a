"""grpcurl: every RPC by the server's reflection, without a file of the protocol."""
from __future__ import annotations

import base64
import json
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import grpc
import pytest
from google.protobuf import json_format
from google.protobuf.any_pb2 import Any as AnyMessage

import stiefel
import tools
from exchange import Answer, Call, calls, compare, reason_in
from stiefel import v1 as pb

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


def detail_of(detail: Any) -> AnyMessage:
    """An Any of a google.rpc message, which grpcurl writes in base64, because reflection does not know its type."""
    return AnyMessage(type_url=detail["@type"], value=base64.b64decode(detail["@value"]))


def reply_of(rpc: str, reply: Any) -> Any:
    details = reply.get("error", {}).pop("details", []) if rpc == "Drive" else []
    message = json_format.ParseDict(reply, getattr(pb, f"{rpc}Response")())
    if details:
        message.error.details.extend(map(detail_of, details))
    return message


def call_by(grpcurl: Path, address: str, call: Call) -> Answer:
    done = subprocess.run([grpcurl, "-plaintext", "-format-error", "-max-msg-sz", str(2**31 - 1), "-H", f"stiefel-session: {call.session}", "-d", "@", address,
                           f"{SERVICE}/{call.rpc}"],
                          input="\n".join(map(json.dumps, call.requests)), capture_output=True, text=True, timeout=300)
    replies = [reply_of(call.rpc, value) for value in documents(done.stdout)]
    if done.returncode == 0:
        return Answer(replies)
    error = next(documents(done.stderr[done.stderr.index("{"):]))
    code = next(code.name for code in grpc.StatusCode if code.value[0] == error["code"])
    assert done.returncode == 64 + error["code"]
    return Answer([], code, reason_in(map(detail_of, error.get("details", []))))


def test_every_rpc(grpcurl: Path, server: stiefel.Server) -> None:
    made = calls()
    compare(made, [call_by(grpcurl, server.address, call) for call in made])


def test_the_service_is_listed_and_described(grpcurl: Path, server: stiefel.Server) -> None:
    def ask(*arguments: str) -> str:
        return subprocess.run([grpcurl, "-plaintext", server.address, *arguments], capture_output=True, text=True, check=True).stdout
    listed = ask("list", SERVICE).split()
    declared = stiefel.v1.simulation_pb2.DESCRIPTOR.services_by_name["SimulationService"].methods
    assert sorted(listed) == sorted(f"{SERVICE}.{method.name}" for method in declared)
    assert "rpc Step ( .stiefel.v1.StepRequest )" in ask("describe", SERVICE)
