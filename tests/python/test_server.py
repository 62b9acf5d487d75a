"""stiefel.Server: it starts, it stops, and it never outlives the one who started it."""
import os
import subprocess
import sys
import tempfile
import time

import pytest

import stiefel
from stiefel.server import find_server


def is_running(process_id):
    try:
        with open(f"/proc/{process_id}/stat", encoding="ascii") as stat:
            return stat.read().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


def wait_until_gone(process_id):
    for _ in range(1000):
        if not is_running(process_id):
            return True
        time.sleep(0.01)
    return False


def test_it_stops_with_its_block():
    with stiefel.Server.start() as server:
        assert server.address.startswith("unix:")
        with stiefel.Client(server.address) as client:
            assert client.describe().version
    assert server.process.returncode == 0
    assert not os.path.exists(server.address[len("unix:"):])


def test_who_calls_a_server_that_is_gone_is_told_why_it_went():
    with stiefel.Client(stiefel.Server.start().address) as client, pytest.raises(stiefel.Unavailable, match=(
            r"^cannot reach unix:.*; nothing held what Server.start\(\) returned, so the server ended: keep it in a variable")):
        client.describe()
    server = stiefel.Server.start()
    server.stop()
    with stiefel.Client(server.address) as client, pytest.raises(stiefel.Unavailable, match="; its Server was stopped$"):
        client.describe()
    with stiefel.Client("unix:/nowhere") as client, pytest.raises(stiefel.Unavailable, match="there is no such socket$"):
        client.describe()


@pytest.mark.parametrize("end", ["sys.exit(0)", "os._exit(1)", "os.kill(os.getpid(), signal.SIGKILL)"])
def test_it_never_outlives_its_parent(end):
    program = ("import os, signal, sys, stiefel; server = stiefel.Server.start();"
               f"print(server.process.pid, flush=True); {end}")
    run = subprocess.run([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True)
    assert wait_until_gone(int(run.stdout))


@pytest.fixture
def program(tmp_path, monkeypatch):
    """Makes a shell script the server."""
    def program(text):
        path = tmp_path / "stiefel-server"
        path.write_text(f"#!/bin/sh\n{text}\n")
        path.chmod(0o755)
        monkeypatch.setenv("STIEFEL_SERVER", str(path))
        return path
    return program


@pytest.fixture
def sockets(tmp_path, monkeypatch):
    """The folder of the servers' sockets, which nobody else uses."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    return tmp_path / f"stiefel-{os.getuid()}"


def test_a_program_that_says_nothing_is_killed(program, tmp_path, sockets):
    program(f"echo $$ > {tmp_path}/pid; echo loading >&2; trap '' TERM; while :; do sleep 0.05; done")
    with pytest.raises(stiefel.Unavailable, match="did not say within 2 s where it listens.*\n  loading") as caught:
        stiefel.Server.start(timeout=2)
    assert caught.value.metadata == {"exit_status": "None"}
    assert not is_running(int((tmp_path / "pid").read_text())) and list(sockets.iterdir()) == []


def test_sockets_are_in_a_folder_of_this_user_alone(sockets):
    with stiefel.Server.start() as one, stiefel.Server.start() as other:
        assert sockets.stat().st_mode & 0o777 == 0o700
        assert {f"unix:{path}" for path in sockets.iterdir()} == {one.address, other.address}
        other.process.kill()
        other.process.wait()
        assert len(list(sockets.iterdir())) == 2  # which a killed server cannot help
    assert list(sockets.iterdir()) == []


@pytest.mark.parametrize("make", [lambda folder: folder.mkdir(0o755), lambda folder: folder.symlink_to("/"),
                                  lambda folder: folder.write_text("")])
def test_a_folder_that_others_may_enter_is_refused(sockets, make):
    make(sockets)
    with pytest.raises(stiefel.Unavailable, match="must be a folder that belongs to this user"):
        stiefel.Server.start()


def test_a_program_that_ends_at_once(program):
    program("echo one >&2; echo two >&2; exit 7")
    with pytest.raises(stiefel.Unavailable, match="exit status 7 before it listened.*\n  one\n  two") as caught:
        stiefel.Server.start()
    assert caught.value.metadata == {"exit_status": "7"}
    program("printf 'listening on '; exec sleep 100")  # half a line is nothing
    with pytest.raises(stiefel.Unavailable, match="did not say"):
        stiefel.Server.start(timeout=0.3)
    program("echo hello")
    with pytest.raises(stiefel.Unavailable, match="it said 'hello'"):
        stiefel.Server.start()
    program("kill -9 $$")  # twice
    with pytest.raises(stiefel.Unavailable, match="exit status -9 .* it wrote nothing to stderr"):
        stiefel.Server.start()


def test_a_program_that_a_signal_ends_is_started_once_more(program, tmp_path):
    real = stiefel.server.find_server()
    program(f"[ -e {tmp_path}/again ] && exec '{real}' \"$@\"; touch {tmp_path}/again; kill -ABRT $$")
    with stiefel.Server.start() as server, stiefel.Client(server.address) as client:
        assert client.describe().version


def test_what_is_no_program(tmp_path, monkeypatch):
    (tmp_path / "text").write_bytes(b"\x7fELF no program")
    (tmp_path / "text").chmod(0o755)
    monkeypatch.setenv("STIEFEL_SERVER", str(tmp_path / "text"))
    with pytest.raises(stiefel.Unavailable, match="cannot be run: Exec format error"):
        stiefel.Server.start()


def test_what_it_writes_to_stderr_is_seen(capfd, program):
    program("echo early >&2; echo listening on nowhere; echo late >&2; read line; echo last >&2")
    with stiefel.Server.start() as server:
        server.process.stdin.close()
        server.process.wait(60)
    assert capfd.readouterr().err == "early\nlate\nlast\n"


def test_a_server_that_is_nowhere(monkeypatch, tmp_path):
    """The error names every place where it looked."""
    monkeypatch.setattr("stiefel.server.__file__", str(tmp_path / "lib/stiefel/server.py"))
    monkeypatch.delenv("STIEFEL_SERVER", raising=False)
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(FileNotFoundError) as caught:
        stiefel.Server.start()
    for place in ("STIEFEL_SERVER", f"{tmp_path}/bin/stiefel-server", f"PATH ({tmp_path})"):
        assert place in str(caught.value)
    monkeypatch.setenv("STIEFEL_SERVER", "/no/such/program")
    with pytest.raises(FileNotFoundError, match="STIEFEL_SERVER is /no/such/program"):
        stiefel.Server.start()


def test_where_it_is_looked_for(monkeypatch, tmp_path):
    """STIEFEL_SERVER, then the build tree around the package, then PATH."""
    for name in ("given", "bin", "path"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "stiefel-server").write_text("#!/bin/sh")
        (tmp_path / name / "stiefel-server").chmod(0o755)
    monkeypatch.setattr("stiefel.server.__file__", str(tmp_path / "python/stiefel/server.py"))
    monkeypatch.setenv("PATH", str(tmp_path / "path"))
    monkeypatch.setenv("STIEFEL_SERVER", str(tmp_path / "given/stiefel-server"))
    assert find_server() == str(tmp_path / "given/stiefel-server")
    monkeypatch.delenv("STIEFEL_SERVER")
    assert find_server() == str(tmp_path / "bin/stiefel-server")
    (tmp_path / "bin/stiefel-server").unlink()
    assert find_server() == str(tmp_path / "path/stiefel-server")


def test_the_programs_of_the_wheel_come_before_those_of_the_build_tree(tmp_path, monkeypatch):
    """A console script of the wheel on PATH would start a Python for nothing."""
    (tmp_path / "stiefel-server").write_text("#!/bin/sh")
    monkeypatch.setattr("stiefel._programs._FOLDER", tmp_path)
    monkeypatch.delenv("STIEFEL_SERVER", raising=False)
    assert find_server() != str(tmp_path / "stiefel-server")
    (tmp_path / "stiefel-server").chmod(0o755)
    assert find_server() == str(tmp_path / "stiefel-server")
