"""The calls that a peer makes as JSON, and what Python's gRPC gets for them, to compare with what the peer gets."""
from __future__ import annotations

import sys
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import grpc
import numpy as np
from google.protobuf import json_format
from google.protobuf.message import Message

import stiefel
from stiefel import v1 as pb
from stiefel.v1.simulation_pb2_grpc import SimulationServiceStub

sys.path.insert(0, str(Path(__file__).parents[1] / "calls"))
from every_call import STREAMS, every_call  # noqa: E402

VOLATILE = {"create_time", "expire_time", "cpu_seconds_per_second", "steps_per_second"}  # clocks
N = 512
LARGE = {"system": "rigid_body", "step": 0.01, "method": "rk4", "inertia": np.linspace(1, 2, N),
         "initial": {"Q": np.eye(N), "M": (np.tri(N) - np.tri(N).T) / N}}


@dataclass(frozen=True)
class Call:
    rpc: str
    requests: list[Any]  # of JSON; several for Drive only
    fails: tuple[str, str] = ("OK", "")  # status code and ErrorInfo.reason

    @property
    def session(self) -> str:
        """Of the metadata stiefel-session."""
        return str(self.requests[0].get("from_session_id") or self.requests[0].get("session_id", ""))


@dataclass
class Answer:
    replies: list[Any] = field(default_factory=list)
    code: str = "OK"
    reason: str = ""


def as_json(message: Message) -> Any:
    return json_format.MessageToDict(message, preserving_proto_field_name=True)


def calls() -> list[Call]:
    """Those of every_call.txtpb, one that is wrong in a Drive, which goes on, and those of a state of more than 4 MiB."""
    found = [Call(rpc, [as_json(message) for message in messages]) for rpc, messages in every_call()]
    next(call for call in found if call.rpc == "Drive").requests.insert(1, {"to": -1})
    return [*found, Call("Step", [{"session_id": "none", "to": 1}], ("NOT_FOUND", "SESSION_NOT_FOUND")),
            Call("CreateSession", [{"session_id": "wrong", "scene": {"system": "rigid_body"}}], ("INVALID_ARGUMENT", "")),
            Call("CreateSession", [{"session_id": "large", "scene": as_json(stiefel.to_message(LARGE))}]),
            Call("Step", [{"session_id": "large", "to": 2}]), Call("Stream", [{"session_id": "large", "to": 2}])]


def reason_in(details: Iterable[Any]) -> str:
    return next((pb.ErrorInfo.FromString(one.value).reason for one in details if one.type_url.endswith(".ErrorInfo")), "")


def ask(address: str, calls: list[Call]) -> list[Answer]:
    with grpc.insecure_channel(address, options=[("grpc.max_receive_message_length", -1)]) as channel:
        return [_ask(SimulationServiceStub(channel), call) for call in calls]


def _ask(stub: Any, call: Call) -> Answer:
    requests = [json_format.ParseDict(request, getattr(pb, f"{call.rpc}Request")()) for request in call.requests]
    try:
        got = getattr(stub, call.rpc)(iter(requests) if call.rpc == "Drive" else requests[0], metadata=[("stiefel-session", call.session)])
        return Answer(list(got) if call.rpc in STREAMS else [got])
    except grpc.RpcError as error:
        status = pb.Status.FromString(dict(error.trailing_metadata())["grpc-status-details-bin"])
        return Answer([], error.code().name, reason_in(status.details))


def compare(calls: list[Call], answers: list[Answer]) -> None:
    """The answers are those that Python's gRPC gets from a server of its own."""
    with stiefel.Server.start("127.0.0.1:0") as other:
        for call, answer, expected in zip(calls, answers, ask(other.address, calls), strict=True):
            assert (answer.code, answer.reason) == (expected.code, expected.reason) == call.fails, call.rpc
            assert len(answer.replies) > 0 or call.fails[0] != "OK", call.rpc
            mine, theirs = whole(answer.replies), whole(expected.replies)
            assert mine == theirs, f"{call.rpc}: {[key for key in theirs if mine.get(key) != theirs[key]]}"
            if call.rpc == "Drive":
                assert [reply.WhichOneof("result") for reply in answer.replies].count("error") == 1


def whole(replies: list[Any]) -> dict[str, Any]:
    """What a call answers, its messages put together: how samples are divided into messages is no part of it."""
    together: dict[str, Any] = {}
    for reply in replies:
        rest = type(reply)()
        rest.CopyFrom(reply)
        for name in ("fields", "blocks", "statistics"):
            for each in getattr(reply, name, []):
                together[each.name] = together.get(each.name, b"") + each.value.data
                rest.ClearField(name)
        forget(rest)
        together.setdefault("rest", type(reply)()).MergeFrom(rest)
    return together


def forget(message: Message) -> None:
    """Clears VOLATILE, and the measured work of a call; other work is predicted."""
    for descriptor, value in message.ListFields():
        if descriptor.name in VOLATILE or descriptor.name == "work" and descriptor.containing_type.name.endswith("Response"):
            message.ClearField(descriptor.name)
        elif descriptor.message_type and not descriptor.message_type.GetOptions().map_entry:
            for each in [value] if isinstance(value, Message) else value:
                forget(each)
