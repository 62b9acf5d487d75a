"""A Unix socket: its owner's alone, of one server at a time, and removed by nobody else."""
import os
import signal
import socket
import stat
import subprocess

import pytest

import stiefel


@pytest.fixture
def path(tmp_path):
    return f"{tmp_path}/socket"


def serves(path):
    with stiefel.Client(f"unix:{path}") as client:
        return bool(client.describe().version)


def start_in_vain(path):
    """What a second server says, and its exit status."""
    run = subprocess.run([os.environ["STIEFEL_SERVER"], "--listen", f"unix:{path}"], capture_output=True, text=True,
                         timeout=60)
    return run.returncode, run.stderr


@pytest.mark.parametrize("umask", [0o000, 0o022, 0o077])
def test_it_is_for_its_owner_only(serve, path, umask):
    before = os.umask(umask)
    try:
        serve(listen=f"unix:{path}")
    finally:
        os.umask(before)
    assert stat.S_IMODE(os.stat(path).st_mode) == 0o600


def test_a_second_server_refuses_to_start_and_the_first_goes_on(serve, path):
    serve(listen=f"unix:{path}")
    status, said = start_in_vain(path)
    assert status == 1 and f"cannot listen on unix:{path}: another server listens there" in said
    assert serves(path)


def test_the_socket_of_a_server_that_was_killed_is_replaced(serve, path):
    process = serve(listen=f"unix:{path}")
    process.child.send_signal(signal.SIGKILL)
    process.child.wait(60)
    assert os.path.exists(path)
    serve(listen=f"unix:{path}")
    assert serves(path)


def test_another_file_is_left_alone(path):
    with open(path, "w", encoding="ascii") as file:
        file.write("precious")
    status, said = start_in_vain(path)
    assert status == 1 and "the path is a file and no socket" in said
    with open(path, encoding="ascii") as file:
        assert file.read() == "precious"


def test_a_socket_that_is_not_its_own_any_more_stays(serve, path):
    first = serve(listen=f"unix:{path}")
    os.unlink(path)
    serve(listen=f"unix:{path}")
    assert first.stop() == 0
    assert serves(path)


def test_its_own_is_removed(serve, path):
    assert serve(listen=f"unix:{path}").stop() == 0
    assert not os.path.exists(path)


def test_of_two_that_start_at_once_over_a_dead_socket_one_serves(path):
    dead = socket.socket(socket.AF_UNIX)
    dead.bind(path)
    dead.close()
    command = [os.environ["STIEFEL_SERVER"], "--listen", f"unix:{path}", "--exit-with-parent"]
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.DEVNULL}
    two = [subprocess.Popen(command, **pipes) for _ in range(2)]
    said = sorted(one.stdout.readline() for one in two)
    assert said == [b"", f"listening on unix:{path}\n".encode()]
    assert serves(path)
    for one in two:
        one.stdin.close()
    assert sorted(one.wait(60) for one in two) == [0, 1]
