"""In a bare Debian with Python, `pip install` of the one wheel is all that the README's first program needs.

    bare_debian.py SUITE FOLDER_OF_WHEELS

Needs root, mmdebstrap and PyPI; the bare system itself needs no network.
"""
from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from environment import PIP, environment, skip, wheel_in

README = Path(__file__).parents[2] / "README.md"
VERSIONS = {"bullseye": "3.9", "bookworm": "3.11", "trixie": "3.13"}
TRY = """\
set -eu
cd /try
python3 -m venv there
there/bin/pip install --quiet --no-index --find-links packages packages/WHEEL
ls /usr/bin/*grpc* /usr/lib/*/libgrpc* 2>/dev/null && exit 1
cd /
/try/there/bin/python /try/program.py
/try/there/bin/stiefel --version
/try/there/bin/stiefel-server --version
"""


def first_program() -> tuple[str, str]:
    """The README's first program in Python, and what it prints."""
    page = README.read_text(encoding="utf-8")
    program = re.search(r"^```python\n(.*?)^```", page, re.DOTALL | re.MULTILINE)
    prints = re.search(r"^prints\n+```text\n(.*?)^```", page, re.DOTALL | re.MULTILINE)
    assert program and prints
    return program[1], prints[1]


def main(suite: str, wheels: Path) -> None:
    if os.getuid() != 0 or not shutil.which("mmdebstrap"):
        skip("needs root and mmdebstrap")
    wheel, (program, prints) = wheel_in(wheels), first_program()
    with tempfile.TemporaryDirectory(prefix="bare-python.") as name:
        folder = Path(name)
        root = folder / "root"
        made = subprocess.run(["mmdebstrap", "--quiet", "--variant=minbase", "--include=python3,python3-venv", suite, root])
        if made.returncode != 0:
            skip(f"mmdebstrap cannot make {suite}")
        there = root / "try"
        (there / "packages").mkdir(parents=True)
        pip = environment(folder / "pip")
        version = VERSIONS[suite]
        got = subprocess.run([pip, "-m", "pip", "download", *PIP, "--python-version", version, "--dest", there / "packages", wheel])
        if got.returncode != 0:
            skip("pip cannot download what the wheel needs")
        (there / "program.py").write_text(program)
        (there / "run.sh").write_text(TRY.replace("WHEEL", wheel.name))
        mount = 'mount -t proc proc "$0/proc" && mount --rbind /dev "$0/dev" && exec chroot "$0" /usr/bin/env -i ' \
                'PATH=/usr/bin:/bin HOME=/root sh /try/run.sh'
        done = subprocess.run(["unshare", "--mount", "--pid", "--fork", "--kill-child", "bash", "-c", mount, root],
                              capture_output=True, text=True)
        print(done.stdout, done.stderr)
        assert done.returncode == 0
        assert done.stdout.startswith(prints), f"the README says it prints\n{prints}"


if __name__ == "__main__":
    main(sys.argv[1], Path(sys.argv[2]))
