"""The program inside the wheel for this platform, which the console script `stiefel-server` runs.

This folder of the wheel holds the program and all shared libraries that it needs, the C library and its loader among
them. In the build tree and in the wheel for every platform it holds none.
"""
from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Mapping, NoReturn, Optional

_FOLDER = Path(__file__).parent


def bundled(name: str) -> Optional[Path]:
    """Returns the path of a program in this folder; None if it is not there."""
    path = _FOLDER / name
    return path if os.access(path, os.X_OK) and path.is_file() else None


def invocation(program: str, environment: Mapping[str, str]) -> tuple[list[str], dict[str, str]]:
    """Returns the command and the environment that run a program. A loader beside it runs it with the libraries beside it
    and with none of the system, whose C library may be older, newer or another: a library of LD_PRELOAD would need that one."""
    folder = Path(program).parent
    loader = next(folder.glob("ld-linux-*"), None)
    if loader is None:
        return [program], dict(environment)
    return ([str(loader), "--library-path", str(folder), program],
            {name: value for name, value in environment.items() if name != "LD_PRELOAD"})


def server() -> NoReturn:
    """Replaces this process by the server, so that signals and the exit status are the server's."""
    path = bundled("stiefel-server")
    if path is None:
        sys.exit("stiefel-server: this installation of the package holds no programs; the wheel for Linux on x86_64 does")
    command, environment = invocation(str(path), os.environ)
    os.execve(command[0], [*command, *sys.argv[1:]], environment)
