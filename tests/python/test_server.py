"""stiefel.Server: it starts, it stops, and it never outlives the one who started it."""
import os
import subprocess
import sys
import time

import pytest

import stiefel


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


def test_a_free_port():
    with stiefel.Server.start(listen="127.0.0.1:0") as server:
        assert int(server.address.rpartition(":")[2]) > 0
        with stiefel.Client(server.address) as client:
            assert client.describe().version


def test_it_stops_when_forgotten():
    server = stiefel.Server.start()
    process = server.process
    del server
    assert process.wait(10) == 0


@pytest.mark.parametrize("end", ["sys.exit(0)", "os._exit(1)", "os.kill(os.getpid(), signal.SIGKILL)"])
def test_it_never_outlives_its_parent(end):
    program = ("import os, signal, sys, stiefel; server = stiefel.Server.start();"
               f"print(server.process.pid, flush=True); {end}")
    run = subprocess.run([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True)
    assert wait_until_gone(int(run.stdout))


def test_it_outlives_the_thread_that_started_it():
    from concurrent.futures import ThreadPoolExecutor

    with ThreadPoolExecutor(1) as pool:
        server = pool.submit(stiefel.Server.start).result()
    with server, stiefel.Client(server.address) as client:
        assert client.describe().version


def test_arguments_it_does_not_know():
    with pytest.raises(RuntimeError, match="--no-such-flag"):
        stiefel.Server.start(arguments=["--no-such-flag"])


def test_a_server_that_is_nowhere(monkeypatch, tmp_path):
    monkeypatch.setattr("stiefel.server.__file__", str(tmp_path / "server.py"))
    monkeypatch.delenv("STIEFEL_SERVER", raising=False)
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(FileNotFoundError, match="STIEFEL_SERVER"):
        stiefel.Server.start()
