"""Starts the servers to measure: processes that print their address and end with this process."""
from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from authority import Authority  # noqa: E402

_READY = "listening on "


class Process:
    def __init__(self, command: list[str]):
        self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
                                         env={**os.environ, "STIEFEL_LOG_LEVEL": "warn"})
        line = self._process.stdout.readline().strip()
        if not line.startswith(_READY):
            self._process.kill()
            raise RuntimeError(f"{command[0]} said {line!r}")
        self.address = line[len(_READY):]
        self.pid = self._process.pid

    def __enter__(self) -> Process:
        return self

    def __exit__(self, *exception: object) -> None:
        self._process.communicate()  # closes the stdin of the process, which ends it


def stiefel_server(build: Path, *arguments: object) -> Process:
    """Starts a server with quiet logging and the options that programs use."""
    return Process([str(build / "bin/stiefel-server"), "--listen", "127.0.0.1:0", "--exit-with-parent",
                    "--grace", "0", *map(str, arguments)])


def bare_echo(programs: Path) -> Process:
    return Process([str(programs / "bench_echo_server")])


def what_closes(build: Path, folder: Path) -> tuple[list[str], str, str]:
    """Returns the arguments of a server with TLS and one token, the file of its authority, and the token."""
    authority = Authority(folder)
    identity = authority.issue()
    made = subprocess.run([str(build / "bin/stiefel-server"), "token", "bench"], capture_output=True, text=True, check=True)
    token, line = made.stdout.splitlines()
    (folder / "tokens").write_text(line)
    return ["--tls-cert", identity.certificate, "--tls-key", identity.key, "--tokens", str(folder / "tokens")], authority.ca, token
