"""The RPCs of the service, and the list of calls in every_call.txtpb, one of every RPC."""
from __future__ import annotations

import subprocess
import tempfile
from pathlib import Path
from typing import Any

from google.protobuf import descriptor_pb2, descriptor_pool, message_factory, symbol_database, text_format

import calls_proto
from stiefel import v1  # noqa: F401 (the messages of the requests)
from stiefel.v1 import simulation_pb2

HERE = Path(__file__).parent
METHODS = simulation_pb2.DESCRIPTOR.services_by_name["SimulationService"].methods
RPCS = [method.name for method in METHODS]
#: The RPCs with several replies.
STREAMS = {method.name for method in METHODS if method.server_streaming}


def _kind() -> Any:
    """The type stiefel.test.Calls, which no generated code of Python has."""
    with tempfile.TemporaryDirectory() as folder:
        source, out = Path(folder, "calls.proto"), Path(folder, "out")
        source.write_text(calls_proto.text(), encoding="utf-8")
        subprocess.run(["protoc", f"-I{calls_proto.PROTO}", f"-I{folder}", f"--descriptor_set_out={out}", source], check=True)
        files = descriptor_pb2.FileDescriptorSet.FromString(out.read_bytes())
    pool = descriptor_pool.Default()
    for file in files.file:
        pool.AddSerializedFile(file.SerializeToString())
    calls = pool.FindMessageTypeByName("stiefel.test.Calls")
    if hasattr(message_factory, "GetMessageClass"):  # which protobuf 4.21 does not have
        return message_factory.GetMessageClass(calls)
    return symbol_database.Default().GetPrototype(calls)


def every_call() -> list[tuple[str, list[Any]]]:
    """The RPC of each call, and its requests: one, of Drive several."""
    calls = []
    for call in text_format.Parse((HERE / "every_call.txtpb").read_text(), _kind()()).calls:
        name = call.WhichOneof("request")
        rpc, request = "".join(word.capitalize() for word in name.split("_")), getattr(call, name)
        calls.append((rpc, list(request.requests) if rpc == "Drive" else [request]))
    assert {rpc for rpc, _ in calls} == set(RPCS), "one of every RPC"
    return calls
