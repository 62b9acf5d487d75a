"""Writes the proto file of calls as data: a message `Call` with a field for every RPC of the service, which is named as its RPC.

    python3 calls_proto.py FILE

every_call.txtpb has one of every RPC; who fuzzes, attacks or cancels calls reads it."""
import re
import sys
from pathlib import Path

PROTO = Path(__file__).resolve().parents[2] / "proto"

HEAD = """syntax = "proto3";
package stiefel.test;
{imports}

message Call {{
  oneof request {{
{fields}
  }}
}}

message Calls {{
  repeated Call calls = 1;
  // Every CreateSession gets the last checkpoint that a Step returned.
  bool hand_on_checkpoints = 2;
}}

// The requests of one call, where it has many.
message Drive {{ repeated stiefel.v1.DriveRequest requests = 1; }}
"""


def field_of(rpc: str) -> str:
    """list_sessions of ListSessions."""
    return re.sub(r"(?<!^)(?=[A-Z])", "_", rpc).lower()


def text() -> str:
    service = (PROTO / "stiefel/v1/simulation.proto").read_text(encoding="utf-8")
    rpcs = re.findall(r"^  rpc (\w+)\((stream )?", service, re.MULTILINE)
    requests = re.compile(f"^message ({'|'.join(rpc for rpc, _ in rpcs)})Request {{", re.MULTILINE)
    files = [path for path in sorted(PROTO.glob("stiefel/v1/*.proto")) if requests.search(path.read_text(encoding="utf-8"))]
    return HEAD.format(
        imports="\n".join(f'import "stiefel/v1/{path.name}";' for path in files),
        fields="\n".join(f"    {rpc if many else f'stiefel.v1.{rpc}Request'} {field_of(rpc)} = {number};"
                         for number, (rpc, many) in enumerate(rpcs, 1)))


if __name__ == "__main__":
    Path(sys.argv[1]).write_text(text(), encoding="utf-8")
