"""The descriptors of proto/stiefel/v1: those of the present files, and the committed ones, to which a release commits.

    python3 tests/proto/descriptor.py --write    commits to the present files
    python3 tests/proto/descriptor.py --check    says what of the present files is not committed
"""
import subprocess
import sys
import tempfile
from pathlib import Path

from google.protobuf import descriptor_pb2 as pb

from changes import breaking

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


def uncommitted(before: pb.FileDescriptorSet, now: pb.FileDescriptorSet) -> list[str]:
    """What a release of `now` adds to the commitment, or changes in it."""
    return breaking(now, before)


if __name__ == "__main__":
    if sys.argv[1:] == ["--write"]:
        COMMITTED.write_bytes(present().SerializeToString(deterministic=True))
    elif sys.argv[1:] == ["--check"]:
        if new := uncommitted(committed(), present()):
            sys.exit("commit to these with tests/proto/descriptor.py --write:\n" + "\n".join(new))
    else:
        sys.exit(__doc__)
