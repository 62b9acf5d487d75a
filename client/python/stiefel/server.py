"""A server of one's own, as a child process that never outlives its parent."""
from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
import weakref
from pathlib import Path
from typing import Optional, Sequence

_READY = "listening on "
_GRACE = 5.0


class Server:
    """Made by `Server.start()`. `address` is what `Client` takes."""

    def __init__(self, process: "subprocess.Popen[str]", address: str, folder: str):
        self.address = address
        self.process = process
        self._stop = weakref.finalize(self, _stop, process, folder)

    @classmethod
    def start(cls, listen: Optional[str] = None, arguments: Sequence[str] = ()) -> Server:
        """Starts a server on a Unix socket that only this user can reach, or on `listen`.

        "127.0.0.1:0" is a free port. `arguments` go to the command as they are.
        """
        program = find_server()
        folder = tempfile.mkdtemp(prefix="stiefel-")
        command = [program, "--listen", listen or f"unix:{folder}/socket", "--exit-with-parent", *arguments]
        # It stops when its stdin ends, which happens however this process does.
        process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
                                   env={"STIEFEL_LOG_LEVEL": "warn", **os.environ})
        assert process.stdout is not None
        line = process.stdout.readline().strip()
        if not line.startswith(_READY):
            _stop(process, folder)
            raise RuntimeError(f"{' '.join(command)}: exit status {process.returncode}; it said {line!r}")
        return cls(process, line[len(_READY):], folder)

    def stop(self) -> int:
        """Asks it to end, and waits; the exit status."""
        self._stop()
        return self.process.returncode

    def __enter__(self) -> Server:
        return self

    def __exit__(self, *exception: object) -> None:
        self.stop()


def find_server() -> str:
    """`stiefel-server`: what STIEFEL_SERVER names, beside this package, or on PATH."""
    given = os.environ.get("STIEFEL_SERVER")
    beside = Path(__file__).parent / "bin" / "stiefel-server"
    found = given or (str(beside) if beside.exists() else shutil.which("stiefel-server"))
    if not found:
        raise FileNotFoundError("no stiefel-server: not beside this package and not on PATH; "
                                "STIEFEL_SERVER can name it")
    return found


def _stop(process: "subprocess.Popen[str]", folder: str) -> None:
    if process.poll() is None:
        process.terminate()
        try:
            process.wait(_GRACE)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
    for pipe in (process.stdin, process.stdout):
        if pipe is not None:
            pipe.close()
    shutil.rmtree(folder, ignore_errors=True)
