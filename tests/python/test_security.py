"""What the client sends to whom: a token beyond this machine only with TLS."""
import os
import socket
import subprocess
import sys
from pathlib import Path

import grpc
import pytest

import stiefel
from stiefel._server import find_server
from stiefel._wire import address as wire_address

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from authority import Authority  # noqa: E402

BEYOND = ["example.org:50551", "192.0.2.1:50551", "[2001:db8::1]:50551", "10.0.0.1:1", "0.0.0.0:1", "127.0.0.1.example.org:1",
          "localhost.example.org:1", "dns:///localhost:1"]


@pytest.fixture(scope="module")
def token(tmp_path_factory):
    """A token, and the file that admits it."""
    done = subprocess.run([find_server(), "token", "me"], capture_output=True, text=True, check=True)
    token, line = done.stdout.splitlines()
    file = tmp_path_factory.mktemp("token") / "tokens"
    file.write_text(line)
    return token, str(file)


@pytest.mark.parametrize("address", BEYOND)
def test_no_token_in_plaintext_beyond_this_machine(address, monkeypatch):
    with pytest.raises(stiefel.InvalidArgument, match="a token is sent over TLS") as refused:
        stiefel.Client(address, token="secret-one")
    assert "secret-one" not in str(refused.value)
    monkeypatch.setenv("STIEFEL_TOKEN", "secret-one")
    with pytest.raises(stiefel.InvalidArgument):
        stiefel.Client(address)
    stiefel.Client(address, tls=True).close()


def test_a_name_that_does_not_lead_here_gets_no_token(monkeypatch):
    """As if the name passed for one of this machine: the credentials look at the connection."""
    own = next((info[4][0] for info in socket.getaddrinfo(socket.gethostname(), None, socket.AF_INET)
                if not info[4][0].startswith("127.")), None)
    if own is None:
        pytest.skip("this machine has no other address")
    received = []
    with socket.create_server((own, 0)) as listener:
        listener.settimeout(20)
        monkeypatch.setattr(wire_address, "is_local", lambda address: True)
        with stiefel.Client(f"{own}:{listener.getsockname()[1]}", token="secret-one", timeout=3) as client:
            with pytest.raises(stiefel.StiefelError):
                client.describe()
        listener.settimeout(0.1)
        try:
            while True:
                connection, _ = listener.accept()
                connection.settimeout(1)
                received.append(connection.recv(65536))
        except OSError:
            pass
    assert b"secret-one" not in b"".join(received)


@pytest.mark.parametrize("listen", [None, "127.0.0.1:0"])
def test_the_token_over_a_unix_socket_and_loopback(token, listen, monkeypatch):
    with stiefel.Server.start(listen, arguments=["--tokens", token[1]]) as server:
        with stiefel.Client(server.address, token=token[0]) as client:
            with client.create({"system": "rigid_body", "step": 0.1, "body": {
                    "moments": [1, 2, 3], "angular_velocity": [0, 1, 0.1]}}) as session:
                assert session.step(5).step == 5
                assert session.trajectory(to=20).samples == 21
                with session.drive() as drive:
                    assert drive.step(7).step == 7
        with stiefel.Client(server.address) as nobody, pytest.raises(stiefel.StiefelError, match="needs a token") as refused:
            nobody.describe()
        assert refused.value.code is grpc.StatusCode.UNAUTHENTICATED and refused.value.reason == "TOKEN_MISSING" and str(refused.value).endswith("here: give `token`")
        monkeypatch.setenv("STIEFEL_TOKEN", token[0])
        with stiefel.Client(server.address) as known:
            assert known.describe().version


def test_tls_and_token_by_the_environment(token, tmp_path, monkeypatch):
    authority = Authority(tmp_path)
    identity = authority.issue()
    flags = ["--tokens", token[1], "--tls-cert", identity.certificate, "--tls-key", identity.key]
    with stiefel.Server.start("127.0.0.1:0", arguments=flags) as server:
        with stiefel.Client(server.address, tls=authority.ca, token=token[0]) as client:
            assert client.describe().version
        with stiefel.Client(server.address, tls=Path(authority.ca), token="other") as client:
            with pytest.raises(stiefel.StiefelError, match="unknown or was withdrawn"):
                client.describe()
        monkeypatch.setenv("STIEFEL_TLS_CA", authority.ca)
        monkeypatch.setenv("STIEFEL_TOKEN", token[0])
        with stiefel.Client(server.address) as client:
            assert client.describe().version
        credentials = grpc.composite_channel_credentials(
            grpc.ssl_channel_credentials(Path(authority.ca).read_bytes()), grpc.access_token_call_credentials(token[0]))
        with stiefel.Client(channel=grpc.secure_channel(server.address, credentials)) as client:
            assert client.describe().version


def test_a_channel_of_the_callers(client):
    with stiefel.Client(channel=grpc.insecure_channel(client.address)) as other:
        assert other.describe().version
    for more in ({"address": "x:1"}, {"tls": True}, {"token": "x"}):
        with pytest.raises(stiefel.InvalidArgument, match="those of the channel"):
            stiefel.Client(channel=client._channel, **more)


@pytest.mark.parametrize("given, told", [
    *(({"token": token}, "token: it must be printable ASCII") for token in ("", "a\nb", "ä", " x", "x\x00")),
    ({"tls": "/none/ca.pem"}, "/none/.*No such file"), ({"tls": stiefel.Tls(certificate="/none/c.pem", key="/none/k.pem")}, "/none/.*No such file"),
    ({"tls": __file__}, "test_security.py: must hold certificates in PEM"), ({"tls": stiefel.Tls(certificate=os.devnull)}, "one needs the other"),
    ({"tls": True, "address": "unix:/x"}, "a Unix socket has no TLS")])
def test_what_is_no_token_and_no_certificate(given, told):
    with pytest.raises(stiefel.InvalidArgument, match=told) as refused:
        stiefel.Client(**{"address": "127.0.0.1:1", **given})
    assert "\n" not in str(refused.value) and "ä" not in str(refused.value)
