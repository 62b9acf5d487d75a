"""The examples of stiefel.aio: the program, and the gateway for browsers."""
import json
import subprocess
import sys
import time
import urllib.error
import urllib.request
from pathlib import Path

import numpy as np
import pytest

import stiefel
from stiefel.client import Client

EXAMPLES = Path(__file__).parents[3] / "client/examples"
SCENE = EXAMPLES / "scenes/tumbling_spacecraft.json"


@pytest.fixture(scope="module")
def server():
    with stiefel.Server.start() as server:
        yield server


@pytest.fixture(scope="module")
def right(server):
    """The quaternion at every step up to 1000."""
    with Client(server.address) as client, client.create(SCENE) as session:
        return session.trajectory(to=1000, fields="quaternion")["quaternion"].reshape(-1, 4)


def test_the_program(server, right):
    done = subprocess.run([sys.executable, EXAMPLES / "aio/example.py", server.address], capture_output=True, text=True)
    assert done.returncode == 0 and done.stderr == "", done.stderr
    steps = [100, *range(0, 1001, 250), 100, 250, 1000]
    assert done.stdout.splitlines() == [" ".join([f"step {k}:", *map(str, right[k])]) for k in steps]


@pytest.fixture
def server_of_gateway():
    with stiefel.Server.start() as server:
        yield server


@pytest.fixture
def gateway(server_of_gateway):
    command = [sys.executable, EXAMPLES / "browser/gateway.py", "--server", server_of_gateway.address, "--port", "0", "--rate", "1000"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        yield process.stdout.readline().strip()
        process.terminate()


def events(url, count, **headers):
    with urllib.request.urlopen(urllib.request.Request(url + "samples", headers=headers), timeout=600) as reply:
        assert reply.headers["Content-Type"].startswith("text/event-stream")
        found = []
        while len(found) < count:
            id, data, blank = (reply.readline().decode() for _ in range(3))
            found.append(json.loads(data.partition("data: ")[2]))
            assert (id, blank) == (f"id: {found[-1]['step']}\n", "\n")
        return found


def test_a_browser_gets_samples_and_goes_on_where_it_was(gateway, right):
    first = events(gateway, 100)
    again = events(gateway, 100, **{"Last-Event-ID": "99"})
    assert [one["step"] for one in first + again] == list(range(200))
    assert [one["time"] for one in again] == [0.5 * step for step in range(100, 200)]
    assert np.array_equal([one["quaternion"] for one in first + again], right[:200])


def test_a_browser_that_leaves_ends_its_stream(gateway, server_of_gateway):
    events(gateway, 10)
    with Client(server_of_gateway.address) as client:
        session, = client.list()
        end = time.monotonic() + 20
        while not client.get(session.id).message.cursor:  # it moves when a call has ended
            assert time.monotonic() < end
            time.sleep(0.05)


def test_the_page_is_there_and_nothing_else(gateway):
    with urllib.request.urlopen(gateway, timeout=600) as reply:
        assert reply.read() == (EXAMPLES / "browser/index.html").read_bytes()
    with pytest.raises(urllib.error.HTTPError, match="404"):
        urllib.request.urlopen(gateway + "other", timeout=600)
