"""Where metrics are served, to whom, and what else the server of metrics answers."""
import os
import re
import socket
import subprocess

import pytest

from metered import Metered, read


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
    for path in ("/", "/etc/passwd", "/../../etc/passwd", "/%2e%2e/etc/passwd"):
        assert said(url, f"GET {path} HTTP/1.1\r\nhost: a\r\n\r\n".encode()).startswith(b"HTTP/1.1 404"), path
    for method in ("POST", "PUT", "DELETE", "HEAD", "OPTIONS"):
        answer = said(url, f"{method} /metrics HTTP/1.1\r\nhost: a\r\ncontent-length: 0\r\n\r\n".encode())
        assert not answer.startswith(b"HTTP/1.1 200"), method
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


EXPOSED = ["0.0.0.0:0", "0x0:0"]


@pytest.mark.parametrize("address, rule", [
    *[(address, "other machines can reach it") for address in EXPOSED],
    ("unix:/tmp/metrics", "must be host:port"), ("[::1]:0", "must be host:port"), ("127.0.0.1", "has no port"), ("0:0", "must be a name"),
    ("no.such.host.invalid:0", "")])
def test_where_metrics_are_not_served(address, rule):
    for arguments in (["check", "--metrics", address], ["--listen", "127.0.0.1:0", "--metrics", address]):
        told = subprocess.run([os.environ["STIEFEL_SERVER"], *arguments], capture_output=True, text=True, timeout=60)
        assert told.returncode != 0 and address in told.stderr and rule in told.stderr


@pytest.mark.parametrize("at, here", [("127.0.0.1:0", "127.0.0.1"), ("localhost:0", "localhost")])
def test_this_machine_reads_without_more_flags(metered, at, here):
    server = metered(at=at)
    assert server.url.startswith(f"http://{here}:")
    assert server.value("stiefel_threads") >= 1


def test_other_machines_may_read_where_the_operator_says_so(metered):
    url = metered("--insecure", at="0.0.0.0:0").url
    assert read(url.replace("0.0.0.0", "127.0.0.1"))[("stiefel_threads",)] >= 1


def test_a_port_that_is_taken(metered):
    first = metered()
    taken = re.match(r"http://(.*)/metrics", first.url)[1]
    told = subprocess.run([os.environ["STIEFEL_SERVER"], "--listen", "127.0.0.1:0", "--metrics", taken],
                          capture_output=True, text=True, timeout=60)
    assert told.returncode == 1 and taken in told.stderr
