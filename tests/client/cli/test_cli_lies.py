"""A reply that breaks the protocol is a failure, status 1, and no numerical stop, whatever the command."""
import sys
from pathlib import Path

import pytest

import stiefel as package
from stiefel import v1 as pb

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "python/lies"))
import liar  # noqa: E402

SCENE = {"system": "rigid_body", "method": {"name": "variational"}, "step": 0.01,
         "body": {"moments": [1, 2, 3], "angular_velocity": [0.1, 2, 0.1]}}
FRAMES = {"inertia": [1, 2, 3], "time": 1, "Q_0": {"rows": 1, "cols": 3, "values": [1, 0, 0]},
          "Q_T": {"rows": 1, "cols": 3, "values": [0, 1, 0]}}
COMMANDS = {
    "describe": (["Describe"], "describe"),
    "run": (["CreateSession", "Stream", "Diagnose"], "run scene --to 2000 --every 2"),
    "times": (["Summarize", "Diagnose"], "run scene --times times"),
    "diagnose": (["CreateSession", "Diagnose"], "diagnose scene --to 20"),
    "summarize": (["Summarize"], "summarize scene --to 20000 --quantity energy=drift"),
    "convert": (["Convert"], "convert scene --to velocity"),
    "connect": (["Connect"], "connect frames"),
    "tradeoff": (["MeasureTradeoff"], "tradeoff scene --budget 1e7 --repeats 1 --horizon 0.05"),
}


@pytest.fixture(scope="module")
def served(tmp_path_factory):
    with package.Server.start() as right:
        lies, server, address = liar.serve(tmp_path_factory.mktemp("liar"), right.address)
        yield lies, address
        server.stop(None)


def damages(reply, kind):
    """The worst lies: the empty message, bytes that are none, and arrays whose data are cut or of another type."""
    for name, instead in liar.lies(reply, kind):
        if name in ("empty", "garbage", "absent") or name.endswith(("data shorter", "data_type 99", "run_status dropped", "outcome 0")):
            yield name, instead


@pytest.mark.parametrize("command", COMMANDS)
def test_a_reply_that_breaks_the_protocol(stiefel, write, served, command):
    lies, address = served
    methods, line = COMMANDS[command]
    files = {"scene": write(SCENE), "frames": write(FRAMES, "frames.json"), "times": write("0.5 0.25", "times.txt")}
    arguments = [files.get(word, word) for word in line.split()] + ["--server", address]
    lies.truth()
    assert stiefel(*arguments).status == 0
    for method, told in [(method, list(lies.told[method])) for method in methods]:
        kind = getattr(pb, f"{method}Response")
        for index in sorted({0, len(told) - 1}):
            for name, instead in damages(told[index], kind):
                lies.truth()
                lies.lie(method, index, instead)
                found = stiefel(*arguments)
                assert (found.status, found.err.count("\n")) == (1, 1), (method, index, name, found)
                assert found.err.startswith("stiefel: error: ")
