"""A program ends when its last line was run, whatever clients, streams and servers it has left open. gRPC 1.51 to 1.85
never end where one of their threads watches a channel while the interpreter shuts down."""
import os
import subprocess
import sys

import pytest

import fake

LIMIT = 120  #: seconds, after which a program counts as one that never ends; each takes about two
BEGIN = """
import os, subprocess, sys, threading
import stiefel

def describe(client):
    try:
        client.describe()
    except stiefel.Unavailable:
        sys.stdout.write("unavailable\\n")  # at once, because threads do this

def nobody():
    return stiefel.Client("127.0.0.1:1", timeout=2)
"""
SCENE = ("{'system': 'rigid_body', 'method': {'name': 'variational'}, 'step': 0.01, "
         "'body': {'moments': [1, 2, 3], 'angular_velocity': [1, 2, 3]}}")


@pytest.fixture
def program(tmp_path):
    """Runs a program, which finds the fake at ADDRESS, and returns its exit status, its stdout and its stderr."""
    _, server, address = fake.serve(tmp_path)

    def run(text):
        done = subprocess.run([sys.executable, "-c", BEGIN + text], env={**os.environ, "ADDRESS": address},
                              capture_output=True, text=True, timeout=LIMIT)
        return done.returncode, done.stdout, done.stderr

    yield run
    server.stop(None)


@pytest.mark.parametrize("text", [
    "client = nobody(); describe(client)",
    "def call():\n    describe(nobody())\ncall()",  # the client is gone before the exit
    "clients = [nobody() for _ in range(8)]\nthreads = [threading.Thread(target=describe, args=[c]) for c in clients]\n"
    "for t in threads: t.start()\nfor t in threads: t.join()",
    "client = nobody(); describe(client); client.close()",
    "client = stiefel.Client(channel=__import__('grpc').insecure_channel('127.0.0.1:1'), timeout=2); describe(client)",
], ids=["open", "collected", "many", "closed", "channel of the caller's"])
def test_after_a_server_that_cannot_be_reached(program, text):
    status, out, err = program(text)
    assert (status, err) == (0, "") and set(out.split()) == {"unavailable"}


@pytest.mark.parametrize("text", [
    "session.step(to=5)",
    "batches = session.stream(to=1000); next(batches)",
    "drive = session.drive(); drive.step(5)",
    "threading.Thread(target=session.drive().step, args=[5]).start()",
], ids=["call", "stream", "drive", "thread"])
def test_with_a_client_of_a_server_that_answers(program, text):
    begin = "client = stiefel.Client(os.environ['ADDRESS'], timeout=20); session = client.get('fake')\n"
    assert program(begin + text + "\nprint('end')") == (0, "end\n", "")


def test_clients_that_are_open_are_closed(program):
    """A function that was registered before the package was imported runs after its own."""
    at_exit = "import atexit\nclients = []\natexit.register(lambda: print([c.closed for c in clients]))\n"
    program_text = "import stiefel\nclients += [stiefel.Client('127.0.0.1:1') for _ in range(3)]\nclients[0].close()"
    done = subprocess.run([sys.executable, "-c", at_exit + program_text], capture_output=True, text=True, timeout=LIMIT)
    assert (done.returncode, done.stdout, done.stderr) == (0, "[True, True, True]\n", "")


def test_while_a_call_of_another_thread_rests(program):
    """The exit ends the rest, and the thread raises `Closed`, or is gone before it can."""
    status, out, err = program(
        "client = nobody(); rests = threading.Event(); rest = client._connection.rest\n"
        "def told(seconds, away):\n    rests.set(); rest(100.0)\n"
        "client._connection.rest = told\n"
        "threading.Thread(target=client.describe, daemon=True).start(); rests.wait(); print('end')")
    assert (status, out) == (0, "end\n") and (err == "" or "stiefel.errors.Closed" in err)


@pytest.mark.parametrize("end", ["", "client._connection.timeout = 1; server.process.kill(); server.process.wait(); describe(client)"],
                         ids=["running", "killed"])
def test_with_a_server_that_the_program_started(program, end):
    status, out, err = program(
        "server = stiefel.Server.start(); client = stiefel.Client(server.address, timeout=20)\n"
        f"session = client.create({SCENE}); session.step(to=5); drive = session.drive(); drive.step(6)\n"
        f"print(server.process.pid, client.closed); {end}")
    assert status == 0 and err == ""
    with pytest.raises(ProcessLookupError):
        os.kill(int(out.split()[0]), 0)


@pytest.mark.parametrize("begin", [
    "stream = session.stream(to=10**12, every=10**8); next(stream)",
    "threading.Thread(target=session.step, args=[10**12], daemon=True).start()",
    "threading.Thread(target=session.summarize, args=[10**12, {'energy': 'drift'}], daemon=True).start()",
], ids=["stream", "step", "summary"])
def test_while_a_server_that_the_program_started_computes(begin):
    """The call ends before the server is told to end, so that the server, which waits for its calls, need not be killed."""
    text = ("import atexit\natexit.register(lambda: print(server.process.returncode))\n" + BEGIN +
            "server = stiefel.Server.start(arguments=['--grace', '300']); client = stiefel.Client(server.address)\n"
            f"session = client.create({SCENE})\n"
            "def computed():\n    return int(open(f'/proc/{server.process.pid}/stat').read().rpartition(')')[2].split()[11])\n"
            f"before = computed(); {begin}\nwhile computed() < before + 10: pass\n")
    done = subprocess.run([sys.executable, "-c", text], capture_output=True, text=True, timeout=LIMIT)
    assert (done.returncode, done.stdout) == (0, "0\n"), done.stderr
