"""`--server`: addresses, servers that do not answer, and the same bytes from another process."""
import os
import re
import socket
import subprocess

import pytest


@pytest.mark.parametrize("address", ["127.0.0.1:99999", "127.0.0.1:-1", "127.0.0.1", "not a host:1", "unix:"])
def test_what_is_no_address_is_status_2(stiefel, write, scene, address):
    result = stiefel("run", write(scene), "--to", 1, "--server", address)
    assert result.status == 2 and result.err.startswith(f"stiefel: error: cannot reach {address}: ")


@pytest.mark.parametrize("address", ["127.0.0.1:99999", "127.0.0.1:65536", "127.0.0.1:-1", "", "127.0.0.1",
                                     "not a host:0", "unix:" + 108 * "x"])
def test_a_server_listens_on_no_other_address(address):
    server = subprocess.run([os.environ["STIEFEL_SERVER"], f"--listen={address}"], capture_output=True, text=True,
                            timeout=60)
    assert server.returncode != 0 and server.stdout == ""
    assert f"--listen: {address}" in server.stderr


def test_a_server_that_is_not_there_is_status_4(stiefel, write, scene, tmp_path):
    with socket.socket() as silent:  # bound, so that nobody else gets it
        silent.bind(("127.0.0.1", 0))
        for address, reason in [(f"unix:{tmp_path}/none", "there is no such socket"),
                                (f"127.0.0.1:{silent.getsockname()[1]}", "the connection is refused"),
                                ("no-such-host.invalid:50551", "")]:
            result = stiefel("run", write(scene), "--to", 5, "--server", address)
            assert result.status == 4
            assert result.err.startswith(f"stiefel: error: cannot reach {address}: {reason}")
            assert len(result.err.splitlines()) == 1
            assert not re.search("[Aa][Rr][Ee][Ss]|DNS|addresses|UNKNOWN", result.err)


@pytest.mark.parametrize("address, reason", [
    ("localhost:99999", "the port 99999 is not between 1 and 65535"), ("localhost:0", "the port 0 is not between"),
    ("localhost", "the port is missing"), ("localhost:http", "the port 'http' is not a number"),
    ("::1:50551", "[IPv6]:PORT"), ("http://localhost:50551", "without 'http://'"),
])
def test_an_address_that_is_none_is_status_2(stiefel, address, reason):
    result = stiefel("describe", "--server", address)
    assert result.status == 2
    assert result.err.startswith(f"stiefel: error: cannot reach {address}: ") and reason in result.err


def test_another_server_gives_the_same_bytes(stiefel, write, scene, tmp_path):
    address = f"unix:{tmp_path}/server"
    server = subprocess.Popen([os.environ["STIEFEL_SERVER"], "--listen", address])
    try:
        arguments = ["run", write(scene), "--to", 5000, "--every", 50]
        remote = stiefel(*arguments, "--server", address)  # patient while the server starts
        assert remote.status == 0, remote.err
        assert remote.out == stiefel(*arguments).out
        assert stiefel("run", write({**scene, "step": 0}), "--to", 5, "--server", address).status == 2
    finally:
        server.terminate()
        assert server.wait(timeout=30) == 0
