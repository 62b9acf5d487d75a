"""`--tls-ca` and `--token-file`: the command at a server that is closed."""
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "support"))
from authority import Authority  # noqa: E402


@pytest.fixture(scope="module")
def closed(tmp_path_factory):
    """A server with TLS and one token: its address, the authority, and the file of the token."""
    folder = tmp_path_factory.mktemp("closed")
    authority = Authority(folder)
    identity = authority.issue()
    program = os.environ["STIEFEL_SERVER"]
    token, line = subprocess.run([program, "token", "me"], capture_output=True, text=True, check=True).stdout.splitlines()
    (folder / "tokens").write_text(line)
    (folder / "token").write_text(token + "\n")
    server = subprocess.Popen([program, "--listen", "127.0.0.1:0", "--exit-with-parent", "--tls-cert", identity.certificate,
                               "--tls-key", identity.key, "--tokens", folder / "tokens"],
                              stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    yield server.stdout.readline().split()[-1], authority.ca, folder / "token"
    server.stdin.close()
    assert server.wait(20) == 0


def test_the_bytes_of_the_embedded_server(stiefel, write, scene, closed):
    address, ca, token = closed
    arguments = ["run", write(scene), "--to", 500]
    remote = stiefel(*arguments, "--server", address, "--tls-ca", ca, "--token-file", token)
    assert remote.status == 0, remote.err
    assert remote.out == stiefel(*arguments).out


def test_by_the_environment(stiefel, closed, monkeypatch):
    address, ca, token = closed
    monkeypatch.setenv("STIEFEL_TLS_CA", ca)
    monkeypatch.setenv("STIEFEL_TOKEN", token.read_text().strip())
    assert stiefel("describe", "--server", address).status == 0
    assert stiefel("describe").status == 0, "the embedded server has neither"


def test_without_a_token(stiefel, closed):
    address, ca, _ = closed
    result = stiefel("describe", "--server", address, "--tls-ca", ca)
    assert result.status == 1 and result.err == ("stiefel: error: this server needs a token: send the metadata "
                                                 "'authorization: Bearer TOKEN'; here: --token-file or STIEFEL_TOKEN\n")


def test_without_tls(stiefel, closed):
    address, _, token = closed
    result = stiefel("describe", "--server", address, "--token-file", token)
    assert result.status == 4 and result.err == (f"stiefel: error: cannot reach {address}: it closes the connection, as a server with "
                                                 "TLS does to a client without: give --tls-ca or STIEFEL_TLS_CA\n")


def test_the_commands_of_the_page_of_operations(tmp_path):
    """A server with TLS and a token, and its client, as printed."""
    page = (Path(__file__).parents[3] / "docs/operations.md").read_text(encoding="utf-8")
    started, asked = re.search(r"^### Certificates\n.*?```sh\n(.*?)```.*?```sh\n(.*?)```", page, re.DOTALL | re.MULTILINE).groups()
    path = os.pathsep.join(str(Path(os.environ[name]).parent) for name in ("STIEFEL_SERVER", "STIEFEL_CLI"))
    environment = {**os.environ, "PATH": path + os.pathsep + os.environ["PATH"]}
    *made, start = started.strip().rsplit("\n", 1)
    assert subprocess.run(["sh", "-ec", *made], cwd=tmp_path, env=environment, capture_output=True, timeout=120).returncode == 0
    start = start.replace("127.0.0.1:50551", "127.0.0.1:0") + " --exit-with-parent"
    with subprocess.Popen(["sh", "-ec", f"exec {start}"], cwd=tmp_path, env=environment, stdin=subprocess.PIPE,
                          stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as server:
        port = server.stdout.readline().strip().rpartition(":")[2]
        done = subprocess.run(["sh", "-ec", asked.replace("50551", port)], cwd=tmp_path, env=environment, capture_output=True,
                              text=True, timeout=120)
        server.stdin.close()
    assert done.returncode == 0 and done.stdout.startswith("stiefel "), done.stderr


def test_an_authority_that_is_not_the_servers(stiefel, closed, tmp_path):
    address, _, token = closed
    result = stiefel("describe", "--server", address, "--tls-ca", Authority(tmp_path, "stranger").ca, "--token-file", token)
    assert result.status == 4 and result.err == f"stiefel: error: cannot reach {address}: its certificate is not trusted\n"


def test_no_token_in_plaintext_beyond_this_machine(stiefel, closed):
    result = stiefel("describe", "--server", "192.0.2.1:50551", "--token-file", closed[2])
    assert result.status == 2 and "a token is sent over TLS, to this machine or over a Unix socket only" in result.err
    assert closed[2].read_text().strip() not in result.err


@pytest.mark.parametrize("arguments, rule", [
    (["--server", "127.0.0.1:1", "--token-file", "/none"], "token: /none: No such file or directory"),
    (["--server", "127.0.0.1:1", "--token-file", os.devnull], f"token: {os.devnull}: it is empty"),
    (["--server", "127.0.0.1:1", "--tls-ca", "/none"], "tls: ca: /none: No such file or directory"),
    (["--server", "127.0.0.1:1", "--tls-ca", __file__], f"tls: ca: {__file__}: must hold certificates in PEM"),
    (["--token-file", "/none"], "--server"),
])
def test_files_that_are_none(stiefel, arguments, rule):
    result = stiefel("describe", *arguments)
    assert result.status == 2 and rule in result.err
