"""What a server answers to a script: asked by Python's gRPC, read from other clients' JSON, compared."""
from __future__ import annotations

import base64
from dataclasses import dataclass, field
from typing import Any, Iterable

import grpc
from google.protobuf import json_format
from google.protobuf.any_pb2 import Any as AnyMessage
from google.protobuf.message import Message

from script import Call, Json
from every_call import STREAMS  # on the path that script adds
from stiefel import v1 as pb
from stiefel.v1.simulation_pb2_grpc import SimulationServiceStub

# Clocks, and what depends on them.
VOLATILE = {"create_time", "expire_time", "cpu_seconds_per_second", "steps_per_second"}


@dataclass
class Answer:
    replies: list[Any] = field(default_factory=list)
    code: str = "OK"
    reason: str = ""


def request_of(rpc: str, request: Json) -> Message:
    return json_format.ParseDict(request, getattr(pb, f"{rpc}Request")())


def reply_of(rpc: str, reply: Json) -> Message:
    """Of the JSON that protobuf's mapping prescribes."""
    details = reply.get("error", {}).pop("details", []) if rpc == "Drive" else []
    message = json_format.ParseDict(reply, getattr(pb, f"{rpc}Response")())
    if details:
        message.error.details.extend(map(detail_of, details))
    return message


def detail_of(detail: Json) -> Message:
    """An Any of a google.rpc message, whose types this client has under other names: unpacked as JSON, or in base64 as
    grpcurl writes what reflection does not know ("@type", "@value") and protobuf.js everything ("type_url", "value")."""
    url = detail.pop("@type", "") or detail["type_url"]
    if "@error" in detail:
        packed = base64.b64decode(detail["@value"])
    elif "type_url" in detail:
        packed = base64.b64decode(detail["value"])
    else:
        packed = json_format.ParseDict(detail, getattr(pb, url.rsplit(".", 1)[1])()).SerializeToString()
    return AnyMessage(type_url=url, value=packed)


def reason_of(status: bytes) -> str:
    """Of the metadata grpc-status-details-bin."""
    return reason_in(pb.Status.FromString(status).details)


def reason_in(details: Iterable[Any]) -> str:
    for detail in details:
        if detail.type_url == "type.googleapis.com/google.rpc.ErrorInfo":
            return pb.ErrorInfo.FromString(detail.value).reason
    return ""


def ask(address: str, calls: Iterable[Call]) -> list[Answer]:
    """With Python's gRPC and its stock settings."""
    with grpc.insecure_channel(address) as channel:
        stub = SimulationServiceStub(channel)
        return [_ask(stub, call) for call in calls]


def _ask(stub: Any, call: Call) -> Answer:
    requests = [request_of(call.rpc, request) for request in call.requests]
    answer = Answer()
    metadata = (("stiefel-session", call.session),) if call.session else ()
    try:
        got = getattr(stub, call.rpc)(iter(requests) if call.rpc == "Drive" else requests[0], metadata=metadata)
        if call.rpc in STREAMS:
            answer.replies.extend(got)
        else:
            answer.replies.append(got)
    except grpc.RpcError as error:
        answer.code = error.code().name
        answer.reason = reason_of(dict(error.trailing_metadata()).get("grpc-status-details-bin", b""))
    return answer


def check(call: Call, got: Answer, expected: Answer) -> None:
    """The same replies, or the same error; and what the script says of the call."""
    assert (got.code, got.reason) == (expected.code, expected.reason), call.name
    assert (got.code, got.reason) == (call.fails or ("OK", "")), call.name
    if call.fails:
        return
    for reply in [*got.replies, *expected.replies]:
        assert reply.ByteSize() < 4 << 20, f"{call.name}: {reply.ByteSize()} bytes are too many for a stock client"
    assert any(reply.ByteSize() for reply in got.replies) or call.rpc == "DeleteSession", call.name
    mine, theirs = whole(call.rpc, got.replies), whole(call.rpc, expected.replies)
    assert mine.keys() == theirs.keys(), call.name
    for key in mine:
        assert mine[key] == theirs[key], f"{call.name}: {key}"


def whole(rpc: str, replies: list[Any]) -> dict[str, Any]:
    """What a call answers, its parts put together. How a stream is cut into messages is not part of the answer."""
    together: dict[str, Any] = {}
    rest = []
    for original in replies:
        reply = type(original)()
        reply.CopyFrom(original)
        for name in ("fields", "scene_arrays", "blocks", "statistics"):
            for each in getattr(reply, name, []):
                key = f"{name}.{each.name}"
                together[key] = together.get(key, b"") + each.value.data
        if rpc == "Stream":
            for step, time in zip(reply.steps, reply.times):
                together.setdefault("samples", {})[step] = time
            together["checkpoint"] = together.get("checkpoint", b"") + reply.checkpoint.data
            if reply.HasField("run_status"):
                together["run_status"] = reply.run_status
                together["computed_steps"] = reply.computed_steps
        elif rpc == "Summarize" and not any(reply.HasField(name) for name in ("states", "run_status", "price")) \
                and not reply.statistics:
            continue  # progress
        else:
            forget(reply)
            rest.append(reply)
    return {**together, "rest": rest}


def forget(message: Message) -> None:
    """Clears VOLATILE."""
    for descriptor, value in message.ListFields():
        if descriptor.name in VOLATILE:
            message.ClearField(descriptor.name)
        elif descriptor.type == descriptor.TYPE_MESSAGE and not descriptor.message_type.GetOptions().map_entry:
            for each in value if descriptor.label == descriptor.LABEL_REPEATED else [value]:
                forget(each)
