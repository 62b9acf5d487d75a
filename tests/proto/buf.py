"""`buf lint` (STANDARD), and `buf breaking` against the committed descriptor; buf comes from PyPI.

    buf.py FOLDER    fetches buf into FOLDER once; exit status 77 where it cannot be fetched
"""
import os
import subprocess
import sys
import zipfile
from pathlib import Path

from descriptor import COMMITTED, PROTO

VERSION = "1.75.0"
SKIPPED = 77


def fetched(folder: Path) -> Path:
    program = folder / f"buf-{VERSION}"
    if program.exists():
        return program
    folder.mkdir(parents=True, exist_ok=True)
    pip = [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps", "--dest", folder, f"buf-bin=={VERSION}"]
    if subprocess.run(pip).returncode != 0:
        print("buf could not be fetched")
        sys.exit(SKIPPED)
    wheel, = folder.glob(f"buf_bin-{VERSION}-*.whl")
    with zipfile.ZipFile(wheel) as archive:
        name, = (name for name in archive.namelist() if name.endswith("/scripts/buf"))
        part = program.with_suffix(".part")
        part.write_bytes(archive.read(name))
    part.chmod(0o755)
    os.replace(part, program)
    return program


def main() -> int:
    program = fetched(Path(sys.argv[1]))
    # Imports are protobuf's own files, of which buf has another version than protoc.
    calls = [["lint", PROTO], ["breaking", PROTO, "--against", COMMITTED, "--exclude-imports"]]
    return max(subprocess.run([program, *call]).returncode for call in calls)


if __name__ == "__main__":
    sys.exit(main())
