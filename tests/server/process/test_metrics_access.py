"""Where metrics are served, to whom, and what else the server of metrics answers."""
import contextlib
import os
import re
import socket
import ssl
import subprocess
import time

import pytest

from authority import Authority
from conftest import eventually
from metered import Metered, read


def has_ipv6():
    try:
        with socket.socket(socket.AF_INET6) as one:
            one.bind(("::1", 0))
        return True
    except OSError:
        return False


needs_ipv6 = pytest.mark.skipif(not has_ipv6(), reason="this machine has no IPv6")


@pytest.fixture
def metered(serve):
    return lambda *arguments, at="127.0.0.1:0": Metered(serve("--metrics", at, *arguments))


def said(url, request, until_closed=True):
    """What a server of HTTP answers to these bytes."""
    host, port = re.match(r"https?://(.*):(\d+)/", url).groups()
    with socket.create_connection((host.strip("[]"), int(port)), timeout=60) as connection:
        connection.sendall(request)
        return connection.makefile("rb").read() if until_closed else connection.recv(65536)


def test_only_the_metrics_are_served(metered):
    url = metered().url
    for path in ("/", "/metrics/", "/etc/passwd", "/../../etc/passwd", "/metrics/../../etc/passwd", "/%2e%2e/etc/passwd"):
        assert said(url, f"GET {path} HTTP/1.1\r\nhost: a\r\n\r\n".encode()).startswith(b"HTTP/1.1 404"), path
    for method in ("POST", "PUT", "DELETE", "HEAD", "OPTIONS"):
        answer = said(url, f"{method} /metrics HTTP/1.1\r\nhost: a\r\ncontent-length: 0\r\n\r\n".encode())
        assert answer.startswith(b"HTTP/1.1 405") and b"allow: get" in answer.lower(), method
    assert read(url + "?name=stiefel_threads")[("stiefel_threads",)] >= 1


def test_what_is_no_request_is_not_answered(metered):
    server = metered()
    for data in (b"\x16\x03\x01\x02\x00", b"GET\r\n\r\n", b"\0" * 100, b"GET /metrics HTTP/9.9\r\n\r\n",
                 b"GET /" + b"m" * 100_000 + b" HTTP/1.1\r\n\r\n",
                 b"GET /metrics HTTP/1.1\r\n" + b"x: y\r\n" * 100_000 + b"\r\n"):
        try:
            assert b"stiefel_threads" not in said(server.url, data)
        except OSError:  # it hung up while the request was sent
            pass
    assert server.value("stiefel_threads") >= 1


@pytest.mark.parametrize("data", [b"", b"GET /metrics HTTP/1.1\r\nx: y\r\n"], ids=["silent", "half a request"])
def test_silent_readers_hold_up_nobody(metered, data):
    """Of 250 connections, more than have a place, the oldest give way: a page never waits until one of them ends."""
    server = metered()
    host, port = re.match(r"http://(.*):(\d+)/", server.url).groups()
    silent = []
    for _ in range(250):
        silent.append(socket.create_connection((host, int(port))))
        silent[-1].sendall(data)
    begin = time.monotonic()
    assert server.value("stiefel_threads") >= 1
    assert time.monotonic() - begin < 1.9, "before the first of them is closed for its silence"
    silent[0].settimeout(20)
    with contextlib.suppress(ConnectionResetError):
        assert silent[0].recv(1) == b""
    for connection in silent:
        connection.close()


def test_a_reader_that_does_not_read_holds_up_nobody(metered):
    server = metered()
    host, port = re.match(r"http://(.*):(\d+)/", server.url).groups()
    lazy = []
    for _ in range(15):
        lazy.append(socket.create_connection((host, int(port))))
        lazy[-1].setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1)
        lazy[-1].sendall(b"GET /metrics HTTP/1.1\r\nhost: a\r\n\r\n")
    for _ in range(3):
        assert server.value("stiefel_threads") >= 1
    for connection in lazy:
        connection.close()


def test_without_the_flag_there_is_nothing(serve):
    process = serve()
    assert process.stop() == 0
    assert "metrics" not in process.child.stdout.read()


EXPOSED = ["0.0.0.0:0", "[::]:0", "[::ffff:0.0.0.0]:0", "[0:0:0:0:0:0:0:0]:0", "0x0:0"]


@pytest.mark.parametrize("address, rule", [
    *[(address, "other machines can reach it") for address in EXPOSED],
    ("unix:/tmp/metrics", "must be host:port"), ("127.0.0.1", "has no port"), ("0:0", "must be a name"),
    ("no.such.host.invalid:0", "")])
def test_where_metrics_are_not_served(address, rule):
    for arguments in (["check", "--metrics", address], ["--listen", "127.0.0.1:0", "--metrics", address]):
        told = subprocess.run([os.environ["STIEFEL_SERVER"], *arguments], capture_output=True, text=True, timeout=60)
        assert told.returncode != 0 and address in told.stderr and rule in told.stderr


@pytest.mark.parametrize("at, here", [("127.0.0.1:0", "127.0.0.1"), ("localhost:0", "localhost"),
                                      pytest.param("[::1]:0", "[::1]", marks=needs_ipv6)])
def test_this_machine_reads_without_more_flags(metered, at, here):
    server = metered(at=at)
    assert server.url.startswith(f"http://{here}:")
    assert server.value("stiefel_threads") >= 1


@pytest.mark.parametrize("at, here", [("0.0.0.0", ["127.0.0.1"]),
                                      pytest.param("[::]", ["[::1]", "127.0.0.1"], marks=needs_ipv6)])
def test_other_machines_may_read_where_the_operator_says_so(metered, at, here):
    url = metered("--insecure", at=f"{at}:0").url
    for host in here:
        assert read(url.replace(at, host))[("stiefel_threads",)] >= 1


def test_a_port_that_is_taken(metered):
    first = metered()
    taken = re.match(r"http://(.*)/metrics", first.url)[1]
    told = subprocess.run([os.environ["STIEFEL_SERVER"], "--listen", "127.0.0.1:0", "--metrics", taken],
                          capture_output=True, text=True, timeout=60)
    assert told.returncode == 1 and taken in told.stderr and "Address already in use" in told.stderr


class Tls:
    """A server with a certificate for localhost and 127.0.0.1."""

    def __init__(self, folder):
        self.authority = Authority(folder)
        self.own = self.authority.issue()
        self.flags = ["--tls-cert", self.own.certificate, "--tls-key", self.own.key]

    def reader(self, identity=None):
        context = ssl.create_default_context(cafile=self.authority.ca)
        if identity:
            context.load_cert_chain(*identity)
        return context


@pytest.fixture
def tls(tmp_path):
    return Tls(tmp_path)


def fails(url, context):
    """A refused handshake; in TLS 1.3 the refusal comes with the first byte that is read."""
    with pytest.raises(OSError):
        read(url, context)


def test_with_a_certificate_they_are_encrypted(metered, tls):
    url = metered(*tls.flags, at="0.0.0.0:0").url.replace("0.0.0.0", "127.0.0.1")
    assert url.startswith("https://")
    assert read(url, tls.reader())[("stiefel_threads",)] >= 1
    fails(url, ssl.create_default_context())
    fails(url.replace("https", "http"), None)


def test_readers_need_a_certificate_where_clients_do(metered, tls, tmp_path):
    server = metered(*tls.flags, "--tls-client-ca", tls.authority.ca)
    (tmp_path / "elsewhere").mkdir()
    stranger = Authority(tmp_path / "elsewhere").issue("reader")
    assert read(server.url, tls.reader(tls.authority.issue("reader")))[("stiefel_threads",)] >= 1
    for identity in (None, stranger, tls.authority.issue("late", days=-1)):
        fails(server.url, tls.reader(identity))


def test_a_new_certificate_counts_for_the_next_reader(metered, tls):
    server = metered(*tls.flags)

    def serial():
        context = tls.reader()
        host, port = re.match(r"https://(.*):(\d+)/", server.url).groups()
        with socket.create_connection((host, int(port)), timeout=60) as connection, \
                context.wrap_socket(connection, server_hostname=host) as encrypted:
            return encrypted.getpeercert()["serialNumber"]
    first, new = serial(), tls.authority.issue("new")
    for old, path in zip(tls.own, new):
        os.replace(path, old)
    assert eventually(lambda: serial() != first)
    assert read(server.url, tls.reader())[("stiefel_threads",)] >= 1
