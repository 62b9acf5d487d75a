"""The program inside the wheel for this platform, which the console script `stiefel-server` runs.

This folder of the wheel holds the program and the shared libraries that it needs. In the build tree and in the wheel
for every platform it holds none.
"""
from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import NoReturn, Optional

_FOLDER = Path(__file__).parent


def bundled(name: str) -> Optional[Path]:
    """Returns the path of a program in this folder; None if it is not there."""
    path = _FOLDER / name
    return path if os.access(path, os.X_OK) and path.is_file() else None


def server() -> NoReturn:
    _run("stiefel-server")


def _run(name: str) -> NoReturn:
    """Replaces this process by the program, so that signals and the exit status are the program's."""
    path = bundled(name)
    if path is None:
        sys.exit(f"{name}: this installation of the package holds no programs; the wheel for Linux on x86_64 does")
    os.execv(path, [name, *sys.argv[1:]])
