"""Virtual environments with the wheel and what it needs from PyPI."""
from __future__ import annotations

import subprocess
import sys
import venv
from pathlib import Path
from typing import NoReturn

SKIPPED = 77  # as ctest knows it
PIP = ["--quiet", "--disable-pip-version-check", "--no-input", "--only-binary=:all:"]


def wheel_in(folder: Path) -> Path:
    """The platform wheel."""
    found = list(folder.glob("stiefel-*.whl"))
    assert len(found) == 1, f"{folder} must have one wheel, it has {found}"
    return found[0].resolve()


def environment(folder: Path, *packages: str) -> Path:
    """The interpreter of a new environment with the packages; ends this program as skipped where PyPI has none."""
    venv.create(folder, with_pip=True, clear=True)
    python = folder / "bin/python"
    if packages and subprocess.run([python, "-m", "pip", "install", *PIP, *packages]).returncode != 0:
        skip(f"pip cannot install {', '.join(packages)}")
    return python


def skip(reason: str) -> NoReturn:
    print(f"skipped: {reason}")
    sys.exit(SKIPPED)
