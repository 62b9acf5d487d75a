"""What a change of the proto files breaks for those who use the wire as it was."""
from __future__ import annotations

from typing import Any, Iterator

from google.protobuf import descriptor_pb2 as pb


def _messages(prefix: str, messages: Any) -> Iterator[tuple[str, pb.DescriptorProto]]:
    for message in messages:
        name = f"{prefix}.{message.name}"
        yield name, message
        yield from _messages(name, message.nested_type)


def _enums(file: pb.FileDescriptorProto) -> Iterator[tuple[str, pb.EnumDescriptorProto]]:
    yield from ((f"{file.package}.{enum.name}", enum) for enum in file.enum_type)
    for name, message in _messages(file.package, file.message_type):
        yield from ((f"{name}.{enum.name}", enum) for enum in message.enum_type)


def _facts(files: pb.FileDescriptorSet) -> dict[str, Any]:
    """What a client or a file in JSON relies on, each under its name."""
    facts: dict[str, Any] = {}
    for file in files.file:
        if not file.package.startswith("stiefel"):
            continue
        for name, message in _messages(file.package, file.message_type):
            facts[f"message {name}"] = file.name
            oneofs = [one.name for one in message.oneof_decl]
            for field in message.field:
                oneof = oneofs[field.oneof_index] if field.HasField("oneof_index") else ""
                facts[f"field {field.number} of {name}"] = (
                    field.name, field.json_name, field.type, field.type_name, field.label, field.proto3_optional,
                    oneof)
        for name, enum in _enums(file):
            facts.update({f"value {value.number} of {name}": value.name for value in enum.value})
        for service in file.service:
            for method in service.method:
                facts[f"rpc {file.package}.{service.name}.{method.name}"] = (
                    method.input_type, method.output_type, method.client_streaming, method.server_streaming)
    return facts


def breaking(before: pb.FileDescriptorSet, now: pb.FileDescriptorSet) -> list[str]:
    """What is gone or another: messages, fields by number, values, RPCs. New ones break nothing."""
    old, new = _facts(before), _facts(now)
    return [f"{name}: was {fact}, is {new.get(name, 'gone')}" for name, fact in old.items() if new.get(name) != fact]
