"""The descriptors of proto/stiefel/v1: the committed ones and those of the present files."""
import subprocess
import sys
import tempfile
from pathlib import Path

from google.protobuf import descriptor_pb2 as pb

PROTO = Path(__file__).resolve().parents[2] / "proto"
COMMITTED = PROTO / "descriptor.binpb"


def committed() -> pb.FileDescriptorSet:
    return pb.FileDescriptorSet.FromString(COMMITTED.read_bytes())


def present() -> pb.FileDescriptorSet:
    """With all imports, without comments."""
    with tempfile.NamedTemporaryFile() as out:
        files = sorted(path.relative_to(PROTO) for path in PROTO.glob("stiefel/v1/*.proto"))
        subprocess.run(["protoc", f"-I{PROTO}", "--include_imports", f"--descriptor_set_out={out.name}", *files],
                       check=True, cwd=PROTO)
        return pb.FileDescriptorSet.FromString(Path(out.name).read_bytes())


if __name__ == "__main__":
    if sys.argv[1:] != ["--write"]:
        sys.exit(f"usage: {sys.argv[0]} --write: commits to the present files")
    COMMITTED.write_bytes(present().SerializeToString(deterministic=True))
