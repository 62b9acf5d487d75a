"""Makes a page of every file of the protocol from its comments, as protoc reads them."""
from __future__ import annotations

import subprocess
import tempfile
from pathlib import Path
from typing import Iterator

from google.protobuf import descriptor_pb2 as pb

from text import escaped

_FILE = pb.FileDescriptorProto
_TYPES = {number: name.removeprefix("TYPE_").lower() for name, number in pb.FieldDescriptorProto.Type.items()}


def descriptors(proto: Path) -> list[pb.FileDescriptorProto]:
    """The files of stiefel.v1 with the places of their comments."""
    with tempfile.NamedTemporaryFile() as out:
        files = sorted(path.relative_to(proto) for path in proto.glob("stiefel/v1/*.proto"))
        subprocess.run(["protoc", f"-I{proto}", "--include_source_info", f"--descriptor_set_out={out.name}", *files],
                       check=True, cwd=proto)
        return list(pb.FileDescriptorSet.FromString(Path(out.name).read_bytes()).file)


class Page:
    """The page of one file. A comment is found by its path: numbers of fields of the descriptor, and indices."""

    def __init__(self, file: pb.FileDescriptorProto):
        self._file = file
        self._comments = {tuple(at.path): at.leading_comments or at.trailing_comments for at in file.source_code_info.location}
        self._head = next((text for at in file.source_code_info.location if list(at.path) == [12]
                           for text in [*at.leading_detached_comments, at.leading_comments] if text), "")

    def _comment(self, path: tuple[int, ...]) -> str:
        return escaped(" ".join(self._comments.get(path, "").split()))

    def text(self) -> str:
        name = Path(self._file.name).name
        lines = [f"# {name}", "", escaped(" ".join(self._head.split())), ""]
        for i, service in enumerate(self._file.service):
            lines += self._service(service, (_FILE.SERVICE_FIELD_NUMBER, i))
        for i, message in enumerate(self._file.message_type):
            lines += self._message(message, (_FILE.MESSAGE_TYPE_FIELD_NUMBER, i), message.name)
        for i, enum in enumerate(self._file.enum_type):
            lines += self._enum(enum, (_FILE.ENUM_TYPE_FIELD_NUMBER, i), enum.name)
        return "\n".join(lines) + "\n"

    def _service(self, service: pb.ServiceDescriptorProto, path: tuple[int, ...]) -> Iterator[str]:
        yield from (f"## service {service.name}", "", self._comment(path), "")
        for i, method in enumerate(service.method):
            given = ("stream " if method.client_streaming else "") + _short(method.input_type)
            back = ("stream " if method.server_streaming else "") + _short(method.output_type)
            yield from (f"### {method.name}", "", f"`rpc {method.name}({given}) returns ({back})`", "",
                        self._comment((*path, pb.ServiceDescriptorProto.METHOD_FIELD_NUMBER, i)), "")

    def _message(self, message: pb.DescriptorProto, path: tuple[int, ...], name: str) -> Iterator[str]:
        yield from (f"## {name}", "", self._comment(path), "")
        maps = {f".{self._file.package}.{name}.{nested.name}": nested for nested in message.nested_type if nested.options.map_entry}
        for i, field in enumerate(message.field):
            comment = self._comment((*path, pb.DescriptorProto.FIELD_FIELD_NUMBER, i))
            yield f"- `{_type(field, maps)} {field.name} = {field.number}`" + (f": {comment}" if comment else "")
        yield ""
        for i, nested in enumerate(message.nested_type):
            if not nested.options.map_entry:
                yield from self._message(nested, (*path, pb.DescriptorProto.NESTED_TYPE_FIELD_NUMBER, i), f"{name}.{nested.name}")
        for i, enum in enumerate(message.enum_type):
            yield from self._enum(enum, (*path, pb.DescriptorProto.ENUM_TYPE_FIELD_NUMBER, i), f"{name}.{enum.name}")

    def _enum(self, enum: pb.EnumDescriptorProto, path: tuple[int, ...], name: str) -> Iterator[str]:
        yield from (f"## enum {name}", "", self._comment(path), "")
        for i, value in enumerate(enum.value):
            comment = self._comment((*path, pb.EnumDescriptorProto.VALUE_FIELD_NUMBER, i))
            yield f"- `{value.name} = {value.number}`" + (f": {comment}" if comment else "")
        yield ""


def _short(name: str) -> str:
    return name.removeprefix(".stiefel.v1.").removeprefix(".")


def _type(field: pb.FieldDescriptorProto, maps: dict[str, pb.DescriptorProto]) -> str:
    if field.type_name in maps:
        key, value = maps[field.type_name].field
        return f"map<{_type(key, {})}, {_type(value, {}).removeprefix('optional ')}>"
    kind = _short(field.type_name) or _TYPES[field.type]
    if field.label == field.LABEL_REPEATED:
        return f"repeated {kind}"
    return f"optional {kind}" if field.proto3_optional else kind


def write(proto: Path, folder: Path) -> None:
    files = descriptors(proto)
    for file in files:
        (folder / f"{Path(file.name).stem}.md").write_text(Page(file).text(), encoding="utf-8")
    names = "\n".join(Path(file.name).stem for file in files)
    (folder / "index.md").write_text(
        "# Protocol\n\nThe service `stiefel.v1.SimulationService` and its messages, made from the comments of "
        f"`proto/stiefel/v1`.\n\n```{{toctree}}\n{names}\n```\n", encoding="utf-8")
