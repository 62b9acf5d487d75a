"""A motion in one call: on a server of the process, from an example, up to a step or a time, on both sides of time 0."""
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import stiefel
from test_server import gone

EXAMPLES = Path(__file__).parents[2] / "client" / "examples" / "scenes"
TOP = {"system": "rigid_body", "step": 0.1, "epoch": "2016-12-31T23:59:50Z",
       "body": {"moments": [2, 2, 1], "angular_velocity": [0.3, 0, 1]}}  # precesses: omega_x = 0.3 cos(omega_z t / 2)


def omega_x(times):
    """For I = (2, 2, 1), I omega' = I omega x omega gives omega_x' = omega_y omega_z / 2, omega_y' = -omega_x omega_z / 2."""
    return 0.3 * np.cos(np.asarray(times) / 2)


def test_every_call_says_where_it_ends_in_its_own_way():
    for given, times in (({"to": 4}, [0, 0.1, 0.2, 0.3, 0.4]), ({"to": 4.0, "every": 3}, [0, 0.3, 0.4]), ({"time": 0.3}, [0, 0.1, 0.2, 0.3]),
                         ({"time": 0.25, "every": 2}, [0, 0.2, 0.25]), ({"times": [0.7, -0.35, 0, -0.2]}, [0.7, -0.35, 0, -0.2])):
        run = stiefel.simulate(TOP, fields="angular_velocity", **given)
        assert np.allclose(run.time, times, rtol=0, atol=1e-15), given
        assert np.allclose(run["angular_velocity"][:, 0], omega_x(times), rtol=0, atol=1e-14), given


def test_without_an_end_it_is_the_horizon_and_about_1000_samples_are_enough():
    run = stiefel.simulate({**TOP, "horizon": 500})
    assert run.time[-1] == pytest.approx(500) and run.samples == 1001 and run.step[1] == 5
    assert stiefel.simulate(TOP, to=1e6).samples == 1001
    with pytest.raises(stiefel.InvalidArgument, match="to: must be given, or time, or times, because the scene has no horizon"):
        stiefel.simulate(TOP)


def test_a_warning_is_of_the_line_that_called(client):
    thin = {**TOP, "body": {"moments": [1, 2, 4], "angular_velocity": [0.1, 0, 0]}}
    asked = {"servers": [client], "to": 1, "summarize": {"angular_velocity": "last"}}
    for call in (lambda: stiefel.simulate(thin, to=1), lambda: client.create(thin).delete(),
                 lambda: stiefel.sweep({**thin, "epoch": None}, axes={"step": [0.1, 0.2]}, **asked)):
        with pytest.warns(stiefel.SceneWarning, match="no rigid body has these moments") as caught:
            call()
        assert {one.filename for one in caught} == {__file__}


def test_there_is_an_example_of_every_system(client):
    scenes = {name: scene for name, scene in stiefel.examples.items() if name != "frames"}
    assert {scene["system"] for scene in scenes.values()} == {system.name for system in client.describe().systems}
    assert {"toutatis", "envisat", "tumbling_spacecraft"} <= set(scenes)
    for name, scene in scenes.items():
        run = stiefel.simulate(name, to=2)
        assert run.outcome == stiefel.Outcome.REACHED and run.time[-1] == 2 * scene["step"], name
        assert scene == json.loads((EXAMPLES / f"{name}.json").read_text(encoding="utf-8"))
    assert client.geodesics(**stiefel.examples["frames"])[0].residual < 1e-12


def test_a_name_that_is_no_example_is_refused_with_the_near_ones():
    with pytest.raises(FileNotFoundError, match="no example has this name; did you mean toutatis"):
        stiefel.simulate("toutatiss", to=1)
    with pytest.raises(KeyError, match="did you mean envisat"):
        stiefel.examples["Envisat"]
    with pytest.raises(stiefel.InvalidArgument, match="'frames': is no scene"):
        stiefel.simulate("frames", to=1)


SCRIPT = """
import json, multiprocessing, os, stiefel, sys, threading

def one(_=None):
    run = stiefel.simulate("tumbling_spacecraft", to=2)
    return run["quaternion"].ravel().tolist(), stiefel.simulation._own.hold(stiefel.simulation.Share(0)).server.process.pid

if __name__ == "__main__":
    found = {"here": [one(), one()]}
    threads = [threading.Thread(target=lambda: found["here"].append(one())) for _ in range(8)]
    [thread.start() for thread in threads], [thread.join() for thread in threads]
    for kind in ("fork", "spawn"):
        with multiprocessing.get_context(kind).Pool(1) as pool:
            found[kind] = pool.map(one, range(2))
    found["here"].append(one())
    print(json.dumps(found))
"""


def test_a_process_has_one_server_and_a_child_its_own(tmp_path):
    (tmp_path / "script.py").write_text(SCRIPT)
    done = subprocess.run([sys.executable, tmp_path / "script.py"], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0 and done.stderr == "", done.stderr
    found = json.loads(done.stdout)
    states, servers = zip(*(pair for pairs in found.values() for pair in pairs))
    assert all(state == states[0] for state in states)
    assert len(found["here"]) == 11 and len({pid for _, pid in found["here"]}) == 1 and len(set(servers)) == 3
    assert all(gone(pid, 30) for pid in servers), "they end with their processes"


FORKS = """
import os, stiefel

server = stiefel.Server.start()
client = stiefel.Client(server.address)
session = client.create("tumbling_spacecraft")
for k in range(5):
    child = os.fork()
    if child == 0:
        with stiefel.Client(server.address) as mine:
            same = mine.get(session.id).step(to=3)["quaternion"] == session.step(to=3)["quaternion"]
        os._exit(0 if same.all() else 1)
    assert os.waitpid(child, 0)[1] == 0
    assert client.describe() and session.step(to=2).step == 2
client.close()
server.stop()
"""


def test_a_process_that_forks_keeps_its_clients_and_the_child_has_them_too(tmp_path):
    (tmp_path / "script.py").write_text(FORKS)
    done = subprocess.run([sys.executable, "-W", "ignore", tmp_path / "script.py"], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr


def test_a_fork_may_change_the_state_and_keeps_the_clock(client):
    """An impulse of 0.1 rad/s about z at t = 1 s changes the rate of precession from 1/2 to 1.1/2."""
    with client.create(TOP) as session:
        state = session.step(time=1.0)
        at_1 = state["angular_velocity"].ravel()
        with session.fork(at=10, body={"angular_velocity": at_1 + [0, 0, 0.1]}) as fork:
            assert fork.epoch == "2016-12-31T23:59:51 UTC" and fork.scene["epoch"] == fork.epoch
            first, later = fork.step(to=0), fork.step(time=0.75)["angular_velocity"].ravel()
        assert np.allclose(first["quaternion"], state["quaternion"], rtol=0, atol=1e-15)
        angle = 0.75 * 1.1 / 2
        assert later[0] == pytest.approx(at_1[0] * np.cos(angle) + at_1[1] * np.sin(angle), abs=1e-14)
        with session.fork(time=15.0) as over:
            assert over.epoch == "2017-01-01T00:00:04 UTC", "a second of that minute is a leap second"
        with pytest.raises(stiefel.InvalidArgument, match="initial: the scene has `body`"):
            session.fork(at=1, initial={"M": np.zeros((3, 3))})
        with pytest.raises(stiefel.InvalidArgument, match="time: 0.25: must be a whole number of steps of 0.1 s"):
            session.diagnose(time=0.25)


Q = np.array([[0, -1, 0], [0, 0, -1], [1, 0, 0.0]])  # body axes x, y, z are z, -x, -y of space


@pytest.mark.parametrize("given, omega, attitude", [
    ({"angular_velocity": [1, 2, 3], "frame": "space", "attitude": Q}, [3, -1, -2], Q),
    ({"angular_momentum": [2, 4, 3]}, [1, 2, 3], None),
    ({"attitude": [0.5005, 0.5005, -0.5005, -0.5005], "order": "xyzw", "normalize": True}, None,
     [[0, 0, -1], [1, 0, 0], [0, -1, 0]]),
], ids=["space", "momentum", "xyzw"])
def test_a_fork_takes_a_body_in_every_form(client, given, omega, attitude):
    """What is not given is that of the state at the fork, in space axes too."""
    given = dict(given)
    normalize = given.pop("normalize", False)
    with client.create(TOP) as session:
        state = session.step(to=10, fields=["Q", "angular_velocity"])
        with session.fork(at=10, body=given, normalize=normalize) as fork:
            first = fork.step(to=0, fields=["Q", "angular_velocity"])
    assert np.allclose(first["angular_velocity"], state["angular_velocity"] if omega is None else omega, rtol=0, atol=1e-14)
    assert np.allclose(first["Q"], state["Q"] if attitude is None else attitude, rtol=0, atol=1e-14)


@pytest.mark.parametrize("system", ["rigid_body", "right_rigid_body", "symmetric_rigid_body", "mclachlan_scovel"])
def test_a_fork_takes_velocities_in_n_dimensions(client, system):
    """Twice the velocity is twice the momentum, and the frames stay, of both members."""
    W = np.random.default_rng(3).standard_normal((2, 4, 4)) / 5
    scene = {"system": system, "step": 0.1, "members": 2, "inertia": [1, 2, 3, 4.0],
             "initial": {"Q": np.stack([np.eye(4)] * 2), "Omega": W - W.swapaxes(1, 2)}}
    with client.create(scene) as session:
        state = session.step(to=5, fields=["Q", "Omega"])
        Qdot = state["Omega"] @ state["Q"] if system.startswith("right") else state["Q"] @ state["Omega"]
        for initial in ({"Omega": 2 * state["Omega"]}, {"Qdot": 2 * Qdot}):
            with session.fork(at=5, initial=initial) as fork:
                first = fork.step(to=0, fields=["Q", "Omega"])
            assert np.allclose(first["Omega"], 2 * state["Omega"], rtol=0, atol=1e-14) and np.allclose(first["Q"], state["Q"], rtol=0, atol=1e-14)
        with pytest.raises(stiefel.InvalidArgument, match="scene.initial.Omega: max .*: must be skew-symmetric"):
            session.fork(at=5, initial={"Omega": np.ones_like(Qdot)})
