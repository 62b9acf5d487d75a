"""The server of the wheel takes its C library and its loader from the wheel, and nothing from the system."""
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

import stiefel
from stiefel._programs import invocation
from stiefel._server import find_server

sys.path.insert(0, str(Path(__file__).parents[3] / "client" / "python" / "wheel"))
import bundle  # noqa: E402

pytestmark = pytest.mark.skipif("STIEFEL_SANITIZED" in os.environ, reason="no wheel has a sanitizer")


@pytest.fixture(scope="module")
def programs(tmp_path_factory):
    folder = tmp_path_factory.mktemp("of the wheel")
    bundle.bundle([Path(find_server())], folder)
    return folder


@pytest.fixture(autouse=True)
def _server_of_the_wheel(programs, monkeypatch):
    monkeypatch.setenv("STIEFEL_SERVER", str(programs / "stiefel-server"))


def test_the_process_is_named_and_ends_as_without_a_loader():
    with stiefel.Server.start() as server:
        assert Path(f"/proc/{server.process.pid}/comm").read_text(encoding="ascii") == "stiefel-server\n"
        assert server.stop() == 0
    with stiefel.Server.start() as server:
        server.process.send_signal(signal.SIGABRT)
        assert server.process.wait() == -signal.SIGABRT


@pytest.mark.skipif(os.getuid() != 0, reason="chroot needs root")
def test_the_server_answers_in_an_empty_root(programs):
    """So it does not depend on which C library the system has, older, newer or musl."""
    command, _ = invocation(str(programs / "stiefel-server"), {})
    command = ["/usr/sbin/chroot", str(programs), *(part.replace(str(programs), "") or "/" for part in command)]
    with subprocess.Popen([*command, "--listen", "127.0.0.1:0", "--exit-with-parent"], env={}, text=True,
                          stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL) as server:
        address = server.stdout.readline().rpartition(" ")[2].strip()
        with stiefel.Client(address) as client, client.create({"system": "rigid_body", "step": 0.05, "body": {
                "moments": [1, 2, 3], "angular_velocity": [0.1, 1, 0.1]}}) as session:
            assert session.diagnose(to=100, invariants=["energy"]).invariants[0].drift < 1e-14
        server.stdin.close()
    assert server.returncode == 0
