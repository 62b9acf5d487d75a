"""TLS: whom a client believes, whom a server believes, and certificates that change while calls run."""
import shutil
import socket
import ssl
import threading
import time

import pytest
from authority import Authority
from conftest import BODY, eventually, program, refused_at_the_start

import stiefel


@pytest.fixture(scope="module")
def authority(tmp_path_factory):
    return Authority(tmp_path_factory.mktemp("tls"))


@pytest.fixture(scope="module")
def identity(authority):
    return authority.issue()


def flags(identity):
    return ["--tls-cert", identity.certificate, "--tls-key", identity.key]


def describes(address, **security):
    with stiefel.Client(address, **security) as client:
        return bool(client.describe().version)


def fails(address, reason, **security):
    with pytest.raises(stiefel.Unavailable, match=reason):
        describes(address, **security)


def test_whom_a_client_believes(serve, authority, identity, tmp_path):
    process = serve(*flags(identity), listen=f"127.0.0.1:0,unix:{tmp_path}/socket")
    assert describes(process.address, tls=authority.ca)
    port = process.address.rpartition(":")[2]
    assert describes(f"localhost:{port}", tls=stiefel.Tls(ca=authority.ca))
    fails(process.address, "")  # plaintext
    fails(process.address, "not trusted", tls=Authority(tmp_path, "stranger").ca)
    assert describes(f"unix:{tmp_path}/socket"), "a Unix socket beside it has no TLS"
    other = serve(*flags(authority.issue("elsewhere", ["DNS:elsewhere.example"])))
    fails(other.address, "another name", tls=authority.ca)
    assert describes(other.address, tls=stiefel.Tls(ca=authority.ca, name="elsewhere.example"))


def test_a_certificate_that_has_expired(serve, authority):
    expired = authority.issue("expired", days=-1)
    process = serve(*flags(expired), "--log-level", "warn")
    fails(process.address, "not trusted", tls=authority.ca)
    check = program("check", *flags(expired))
    assert check.returncode == 0 and f"--tls-cert: {expired.certificate}: expired" in check.stderr
    process.stop()
    assert "expired" in process.child.stderr.read()


def test_a_server_that_asks_for_a_certificate(serve, authority, identity, tmp_path):
    client = authority.issue("client", ["DNS:client"])
    stranger = Authority(tmp_path, "stranger").issue("client", ["DNS:client"])
    expired = authority.issue("late", ["DNS:late"], days=-1)
    process = serve(*flags(identity), "--tls-client-ca", authority.ca)
    assert describes(process.address, tls=stiefel.Tls(authority.ca, client.certificate, client.key))
    fails(process.address, "", tls=authority.ca)
    for other in (stranger, expired):
        fails(process.address, "", tls=stiefel.Tls(authority.ca, other.certificate, other.key))
    assert program("healthcheck", "--address", process.address, "--tls-ca", authority.ca).returncode == 1
    done = program("healthcheck", "--address", process.address, *flags(identity), "--tls-client-ca", authority.ca)
    assert done.returncode == 0, done.stderr


def test_old_versions_of_tls_are_refused(serve, authority, identity):
    host, port = serve(*flags(identity)).address.split(":")
    for version, spoken in [(ssl.TLSVersion.TLSv1_1, False), (ssl.TLSVersion.TLSv1_2, True), (ssl.TLSVersion.TLSv1_3, True)]:
        context = ssl.create_default_context(cafile=authority.ca)
        context.set_ciphers("ALL:@SECLEVEL=0")
        context.set_alpn_protocols(["h2"])
        context.minimum_version = context.maximum_version = version
        try:
            with socket.create_connection((host, int(port)), 10) as plain, context.wrap_socket(plain, server_hostname=host):
                assert spoken
        except (ssl.SSLError, ConnectionError):
            assert not spoken


def put(identity, folder):
    """Two files, one after the other, as a person would copy them."""
    shutil.copy(identity.certificate, folder / "server.pem")
    time.sleep(0.7)  # a look falls between the two
    shutil.copy(identity.key, folder / "server.key")


def served_serial(address, authority):
    """Serial number of the certificate that a new connection is shown."""
    host, port = address.split(":")
    context = ssl.create_default_context(cafile=authority.ca)
    context.set_alpn_protocols(["h2"])
    with socket.create_connection((host, int(port)), 10) as plain, context.wrap_socket(plain, server_hostname=host) as tls:
        return tls.getpeercert()["serialNumber"]


def test_a_certificate_exchanged_under_load_loses_no_call(serve, authority, identity, tmp_path):
    shutil.copy(identity.certificate, tmp_path / "server.pem")
    shutil.copy(identity.key, tmp_path / "server.key")
    process = serve("--tls-cert", str(tmp_path / "server.pem"), "--tls-key", str(tmp_path / "server.key"), "--log-level", "info")
    said = []
    reader = threading.Thread(target=lambda: said.extend(process.child.stderr))
    reader.start()
    first = served_serial(process.address, authority)
    stop, calls, lost = threading.Event(), [0, 0], []

    def keep_calling():  # on one connection
        with stiefel.Client(process.address, tls=authority.ca) as client, client.create(BODY) as session:
            to = 0
            while not stop.is_set():
                to += 1
                try:
                    session._connection.stub.Step(stiefel.v1.StepRequest(session_id=session.id, to=to), timeout=60)
                    calls[0] += 1
                except Exception as error:  # without the client's own retries
                    lost.append(error)

    def keep_connecting():  # a new connection for each call
        while not stop.is_set():
            with stiefel.Client(process.address, tls=authority.ca) as client:
                try:
                    client._stub.Describe(stiefel.v1.DescribeRequest(), timeout=60)
                    calls[1] += 1
                except Exception as error:
                    lost.append(error)
    threads = [threading.Thread(target=run) for run in (keep_calling, keep_connecting)]
    for thread in threads:
        thread.start()
    for number in range(2):
        before = served_serial(process.address, authority)
        put(authority.issue(f"next{number}"), tmp_path)
        assert eventually(lambda: served_serial(process.address, authority) != before)
    (tmp_path / "server.pem").write_text("no certificate")
    assert eventually(lambda: "certificates at fault" in "".join(said))
    assert eventually(lambda: min(calls) > 10)
    last = served_serial(process.address, authority)
    stop.set()
    for thread in threads:
        thread.join(60)
    assert not lost, [error.debug_error_string() for error in lost]
    assert last != first
    process.stop()
    reader.join(60)
    said = "".join(said)
    assert said.count("info new certificates") == 2
    assert "PRIVATE KEY" not in said


def test_healthcheck(serve, authority, identity, tmp_path):
    process = serve(*flags(identity))
    at = ["healthcheck", "--address", process.address]
    assert program(*at).returncode == 1, "without TLS"
    assert program(*at, "--tls-ca", authority.ca).returncode == 0
    assert program("healthcheck", "--listen", process.address, "--tls-ca", authority.ca).returncode == 0, "the server's own flags"
    assert program(*at, "--tls-ca", Authority(tmp_path, "stranger").ca).returncode == 1
    environment = {"STIEFEL_LISTEN": process.address, "STIEFEL_TLS_CERT": identity.certificate, "STIEFEL_TLS_KEY": identity.key}
    assert program("healthcheck", **environment).returncode == 0, "as in a container: with the server's own variables"


@pytest.mark.parametrize("files, rule", [
    (["--tls-cert", "{cert}"], "--tls-key: absent: TLS needs both"),
    (["--tls-client-ca", "{ca}"], "--tls-cert: absent: TLS needs both"),
    (["--tls-cert", "{none}", "--tls-key", "{key}"], "--tls-cert: {none}: No such file or directory"),
    (["--tls-cert", "{key}", "--tls-key", "{key}"], "--tls-cert: {key}: it must hold certificates in PEM"),
    (["--tls-cert", "{cert}", "--tls-key", "{cert}"], "--tls-key: {cert}: it must hold a private key in PEM"),
    (["--tls-cert", "{cert}", "--tls-key", "{cakey}"], "--tls-key: {cakey}: it is not the key of the first certificate"),
    (["--tls-cert", "{cert}", "--tls-key", "{key}", "--tls-client-ca", "{key}"],
     "--tls-client-ca: {key}: it must hold certificates in PEM"),
    (["--tls-cert", "/dev/zero", "--tls-key", "{key}"], "--tls-cert: /dev/zero: it must be a regular file"),
])
def test_files_that_are_none_are_refused_at_the_start(authority, identity, tmp_path, files, rule):
    names = {"cert": identity.certificate, "key": identity.key, "ca": authority.ca, "none": tmp_path / "none",
             "cakey": authority.folder / "ca.key"}
    told = refused_at_the_start(*(word.format(**names) for word in files))
    assert all(rule.format(**names) in said for said in told)


@pytest.mark.parametrize("address", ["0.0.0.0:0", "[::]:0"])
def test_no_listening_beyond_this_machine_without_tls(serve, identity, address):
    assert all(f"{address}: other machines can reach it" in said for said in refused_at_the_start(listen=address))
    serve("--insecure", listen=address)
    serve(*flags(identity), listen=address)


@pytest.mark.parametrize("address", ["127.9.9.9:0", "localhost:0", "[::1]:0"])
def test_this_machines_own_addresses_need_none(address):
    assert program("check", "--listen", address).returncode == 0
