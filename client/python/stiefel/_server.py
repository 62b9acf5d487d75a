"""Runs a server as a child process, which ends at the latest with its parent."""
from __future__ import annotations

import atexit
import os
import secrets
import selectors
import shutil
import stat
import subprocess
import tempfile
import time
import weakref
from contextlib import suppress
from pathlib import Path
from typing import IO, Any, Mapping, Optional, Sequence

from stiefel._given.numbers import SECONDS, number
from stiefel._programs import bundled, invocation
from stiefel._wire.connection import close_all
from stiefel._wire.failures import gone
from stiefel.errors import Unavailable

_READY = b"listening on "
_GRACE = 5.0

__all__ = ["Server"]
__dir__ = lambda: sorted(__all__)  # noqa: E731


class Server:
    """A server in a child process, made by `Server.start()`.

    `Client` takes its `address`. As a context manager it stops the server at the end; else the server ends when this object
    is deleted, so keep it.
    """

    def __init__(self, process: "subprocess.Popen[bytes]", address: str, socket: Path):
        self.address = address
        self.process = process
        gone.pop(address, None)
        self._stop = weakref.finalize(self, _let_go, address, process, socket)
        self._stop.atexit = False
        _running.add(self)

    @classmethod
    def start(cls, listen: Optional[str] = None, *, arguments: Sequence[str] = (), timeout: float = 30.0,
              environment: Optional[Mapping[str, str]] = None) -> Server:
        """Starts a server on a Unix socket that only this user can reach, or on the address `listen`.

        "127.0.0.1:0" takes a free port. `arguments` are passed to the program unchanged. `environment` has variables
        for the program; variables of this process take precedence. The program writes to the stderr of this process. Raises
        Unavailable if it ends, or does not say within `timeout` seconds where it listens, in which case it is killed. A
        program that a signal ends before it listens is started once more. Raises FileNotFoundError if there is no program.
        """
        timeout = number("timeout", timeout, SECONDS)
        try:
            return cls._start(listen, arguments, timeout, environment)
        except Unavailable as error:
            if not error.metadata.get("exit_status", "").startswith("-"):
                raise
        return cls._start(listen, arguments, timeout, environment)

    @classmethod
    def _start(cls, listen: Optional[str], arguments: Sequence[str], timeout: float,
               environment: Optional[Mapping[str, str]]) -> Server:
        program, environment = invocation(find_server(),
                                          {"STIEFEL_LOG_LEVEL": "warn", **(environment or {}), **os.environ})
        socket = _socket_folder() / f"{os.getpid()}-{secrets.token_hex(4)}"
        command = [*program, "--listen", listen or f"unix:{socket}", "--exit-with-parent", *arguments]
        try:
            # The server stops when its stdin ends, which happens however this process ends.
            process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, bufsize=0,
                                       env=environment, start_new_session=True)  # Ctrl-C is for this process alone
        except OSError as error:
            raise _not_started(command, f"cannot be run: {error.strerror}", None) from error
        assert process.stdout is not None
        try:
            line = _first_line(process.stdout, timeout)
            if line is not None and line.startswith(_READY):
                return cls(process, os.fsdecode(line[len(_READY):]), socket)
            status = _end(process, _GRACE if line == b"" else 0)
        except BaseException:
            _end(process, 0)
            raise
        finally:
            if process.poll() is not None:
                _stop(process, socket)
        if line is None:
            what = f"did not say within {timeout:g} s where it listens, and was killed"
        else:
            what = f"exit status {status} before it listened" if status is not None else "closed its stdout, and was killed"
            what += f"; it said {os.fsdecode(line)!r}" if line else ""
        raise _not_started(command, what + "; stderr has what it wrote", status)

    def stop(self) -> int:
        """Asks the server to end, waits for it, and returns its exit status."""
        self._stop()
        gone[self.address] = "; its Server was stopped"
        return self.process.returncode

    def _leave_to_parent(self) -> None:
        """Call this in a forked child: the server stays the parent's and ends with it, even if the child lives on."""
        self._stop.detach()
        for pipe in (self.process.stdin, self.process.stdout):
            if pipe is not None:
                pipe.close()

    def __reduce__(self) -> Any:
        raise TypeError("a server cannot be pickled, because it is a process: send its `address`")

    def __enter__(self) -> Server:
        return self

    def __exit__(self, *exception: object) -> None:
        self.stop()

    def __repr__(self) -> str:
        state = "running" if self.process.poll() is None else f"ended with {self.process.returncode}"
        return f"<stiefel.Server at {self.address}, process {self.process.pid}, {state}>"


_running: "weakref.WeakSet[Server]" = weakref.WeakSet()


def _exit() -> None:
    """Ends the calls before their servers, which would wait for them."""
    close_all()
    for server in list(_running):
        held = server._stop.detach()
        if held:
            held[1](*held[2])


def _forked() -> None:
    for server in list(_running):
        server._leave_to_parent()


atexit.register(_exit)

if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forked)


def find_server() -> str:
    """Returns the path of `stiefel-server`: the one that the environment variable STIEFEL_SERVER names, the one inside
    the package, that of the build tree around the package, or the one on PATH. Raises FileNotFoundError."""
    given = os.environ.get("STIEFEL_SERVER")
    if given:
        found = shutil.which(given)
        if not found:
            raise FileNotFoundError(f"STIEFEL_SERVER is {given}: there is no such program")
        return found
    held = bundled("stiefel-server")
    if held is not None:
        return str(held)
    built = Path(__file__).resolve().parents[2] / "bin" / "stiefel-server"
    found = shutil.which(str(built)) or shutil.which("stiefel-server")
    if not found:
        raise FileNotFoundError(
            f"no stiefel-server: STIEFEL_SERVER is not set, {built} does not exist, and none of the folders of PATH "
            f"({os.environ.get('PATH', '')}) has one. The wheel for every platform does not hold the program: name the "
            "one that was built in STIEFEL_SERVER, such as build/release/bin/stiefel-server")
    return found


def _socket_folder() -> Path:
    """Returns the folder with the sockets of this user's servers, which nobody else can enter. It stays, so that a
    process that is killed leaves nothing behind."""
    folder = Path(tempfile.gettempdir(), f"stiefel-{os.getuid()}")
    with suppress(FileExistsError):
        folder.mkdir(0o700)
    found = folder.lstat()
    if not stat.S_ISDIR(found.st_mode) or found.st_uid != os.getuid() or found.st_mode & 0o077:
        raise Unavailable(f"{folder}: must be a folder that belongs to this user and that nobody else can enter; remove it, "
                         "or set TMPDIR to another folder")
    return folder


def _first_line(pipe: IO[bytes], timeout: float) -> Optional[bytes]:
    """Reads the first line without its end. Returns what there was if the pipe ends earlier, and None if neither
    happens within `timeout` seconds."""
    end, line = time.monotonic() + timeout, b""
    with selectors.DefaultSelector() as selector:
        selector.register(pipe, selectors.EVENT_READ)
        while not line.endswith(b"\n"):
            if not selector.select(max(end - time.monotonic(), 0)):
                return None
            part = os.read(pipe.fileno(), 1)
            if not part:
                break
            line += part
    return line.strip()


def _end(process: "subprocess.Popen[bytes]", grace: float) -> Optional[int]:
    """Waits for the process and returns its exit status. Kills it after `grace` seconds and then returns None."""
    try:
        return process.wait(grace)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
        return None


def _not_started(command: Sequence[str], what: str, status: Optional[int]) -> Unavailable:
    return Unavailable(f"{' '.join(command)}: {what}", metadata={"exit_status": str(status)})


def _let_go(address: str, *server: Any) -> None:
    _stop(*server)
    gone[address] = "; nothing held what Server.start() returned, so the server ended: keep it in a variable or a `with`"


def _stop(process: "subprocess.Popen[bytes]", socket: Path) -> None:
    if process.poll() is None:
        process.terminate()
        _end(process, _GRACE)
    for pipe in (process.stdin, process.stdout):
        if pipe is not None:
            pipe.close()
    socket.unlink(missing_ok=True)  # which a server that was killed leaves
