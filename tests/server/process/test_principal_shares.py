"""With --tokens each principal may have half of the sessions and of the memory, unless a flag says otherwise."""
import json
import os
import subprocess

import numpy as np
import pytest

import stiefel
from stiefel import v1 as pb
from test_two_principals import Caller, refusal, token


@pytest.fixture
def principals(serve, tmp_path):
    (alices, her_line), (bobs, his_line) = token("alice"), token("bob")
    (tmp_path / "tokens").write_text(f"{her_line}\n{his_line}\n")

    def start(*more):
        process = serve("--tokens", str(tmp_path / "tokens"), "--log-format", "json", *more)
        return process, Caller(process.address, alices), Caller(process.address, bobs)
    return start


def made(caller, most):
    """Creates sessions until one is refused: their number, and the refusal."""
    for number in range(most + 1):
        if error := refusal(lambda: caller.create(str(number), 0.01)):
            return number, error
    raise AssertionError("nothing was refused")


def test_half_of_the_sessions(principals):
    _, alice, bob = principals("--max-sessions", "7")
    number, error = made(alice, 7)
    assert number == 4 and error.reason == "OVER_QUOTA" and error.quota[0].field == "principal_sessions"
    assert made(bob, 7)[0] == 3


def test_a_flag_decides_also_where_it_is_zero(principals):
    _, alice, _ = principals("--max-sessions", "7", "--principal-sessions", "0")
    number, error = made(alice, 7)
    assert number == 7 and error.reason == "TOO_MANY_SESSIONS"


def test_half_of_the_memory(principals):
    """Of 64 MiB, 40 MiB are for sessions and calls, and a session of this scene takes 3.5 MB and more."""
    process, alice, bob = principals("--memory", "64M")
    scene = stiefel.to_message({"system": "rigid_body", "inertia": list(range(1, 65)), "step": 0.01,
                                "method": {"name": "variational", "order": 2},
                                "initial": {"Q": np.eye(64), "M": np.zeros((64, 64))}})

    def fill(caller):
        """Keeps the simulations of its sessions in use, so that they are no caches."""
        running = []
        for number in range(100):
            id = str(number)
            error = refusal(lambda: caller.call("CreateSession", pb.CreateSessionRequest(session_id=id, scene=scene)))
            if error:
                return running, error
            running.append(caller.begin("Step", pb.StepRequest(session_id=id, to=10**9)))
        raise AssertionError("nothing was refused")
    running, error = fill(alice)
    assert error.quota[0].field == "principal_memory" and float(error.metadata["most"]) == 20 * 2**20
    assert bob.call("CreateSession", pb.CreateSessionRequest(session_id="0", scene=scene)).created
    for call in running:
        call.cancel()
    process.stop()
    lines = [json.loads(line) for line in process.child.stderr]
    limits = next(line for line in lines if line["message"] == "limits of a principal")
    assert limits["sessions"] == 500 and limits["memory_bytes"] == 20 * 2**20


def checked(*arguments, **environment):
    done = subprocess.run([os.environ["STIEFEL_SERVER"], "check", "--memory", "64M", *arguments], capture_output=True,
                          text=True, timeout=60, env={**os.environ, **environment}, check=True)
    return done.stdout.split("of one principal, ")[1].strip()


def test_check_shows_the_limits(tmp_path):
    (tmp_path / "tokens").write_text(token("alice")[1] + "\n")
    tokens = ("--tokens", str(tmp_path / "tokens"))
    assert checked() == "sessions: no limit, bytes of memory: no limit"
    assert checked(*tokens) == "sessions: 500, bytes of memory: 20971520"
    assert checked(*tokens, "--max-sessions", "1") == "sessions: 1, bytes of memory: 20971520"
    assert checked(*tokens, "--principal-memory", "0", STIEFEL_PRINCIPAL_SESSIONS="3") == (
        "sessions: 3, bytes of memory: no limit")
