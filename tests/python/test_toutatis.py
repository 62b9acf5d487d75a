"""The main example, beside an integration that shares nothing with the engine."""
import json
import os
import re
import subprocess
import sys
from dataclasses import replace
from datetime import datetime
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import stiefel

EXAMPLES = Path(__file__).parents[2] / "client" / "examples"
sys.path.insert(0, str(EXAMPLES))
import toutatis  # noqa: E402

DATA = json.loads(toutatis.DATA.read_text(encoding="utf-8"))


def independent_attitudes():
    """Classical Runge-Kutta of order 4 in days and radians on the rotation matrix, 400 steps a day: its
    error, seen by halving the step, is below 1e-6 degrees."""
    moments = np.array(DATA["moments"])

    def field(frame, momentum):
        x, y, z = omega = momentum / moments
        return frame @ np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]]), np.cross(momentum, omega)

    def step(state, h):
        slopes = [field(*state)]
        for weight in (h / 2, h / 2, h):
            slopes.append(field(*(part + weight * slope for part, slope in zip(state, slopes[-1]))))
        return tuple(part + h / 6 * (a + 2 * b + 2 * c + d) for part, a, b, c, d in zip(state, *slopes))

    epoch, now = datetime.fromisoformat(DATA["epoch"]), 0.0
    state = toutatis.attitude(DATA["euler"]), moments * np.radians(DATA["angular_velocity"])
    for observation in DATA["observations"]:
        then = (datetime.fromisoformat(observation["utc"]) - epoch).total_seconds() / toutatis.DAY
        count = int(np.ceil((then - now) * 400))
        for _ in range(count):
            state = step(state, (then - now) / count)
        now = then
        yield state[0]


@pytest.fixture(scope="module")
def session(client):
    with client.create(toutatis.scene(DATA)) as session:
        yield session


@pytest.fixture(scope="module")
def comparisons(session):
    return list(toutatis.compare(session, DATA))


def test_the_attitude_is_the_one_the_angles_mean():
    w, x, y, z = toutatis.quaternion(DATA["euler"])
    rotation = [[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]]
    assert np.allclose(rotation, toutatis.attitude(DATA["euler"]), atol=1e-15)


def test_every_axis_is_where_an_independent_integration_puts_it(comparisons):
    assert len(comparisons) == 17
    for comparison, expected in zip(comparisons, independent_attitudes()):
        apart = comparison._replace(observed=expected).angles()
        assert apart.max() < 1e-4, comparison.utc  # degrees; the engine's own error at 1 s is below 1e-6


def test_the_observations_agree(comparisons):
    angles = np.array([comparison.angles() for comparison in comparisons])
    assert np.median(angles) <= 6 and np.median(angles.max(axis=1)) <= 6
    assert angles.max() < 20


def test_nothing_drifts_in_39_days(session):
    run = session.trajectory(to=toutatis.DAYS * toutatis.DAY, every=toutatis.SAMPLE, fields=["Q", "M"])
    energy, momentum = toutatis.drifts(run, DATA)
    # Plain arithmetic: the roundings of 3.4e6 steps, of random signs, add up to a few times u sqrt(3.4e6) = 2e-13.
    assert energy.max() <= 1e-12 and momentum.max() <= 1e-12
    energy, momentum = toutatis.drifts(run, {**DATA, "moments": [3.0, 3.235, 1.0]})
    assert energy.max() > 1e-3, "with other moments it is not the energy"


def test_a_kept_energy_is_no_accurate_attitude(client):
    """In steps of one hour: the method that keeps the energy best has the worst attitude."""
    found = {name: toutatis.hourly(client, DATA, method) for name, method in toutatis.METHODS.items()}
    drift = {name: one.drift.max() for name, one in found.items()}
    assert drift["variational"] < 1e-13 and drift["recommended"] < 1e-13 and drift["rk4"] > 1e-9
    error = {name: one.error.max() for name, one in found.items()}
    assert error["recommended"] < 1e-9 and 1e-5 < error["rk4"] < 1e-2 and 1 < error["variational"] < 10


def test_the_error_shown_is_that_of_the_closed_form(client):
    rk4 = toutatis.hourly(client, DATA, "rk4")
    attitudes = []
    for method in ("rk4", "exact"):
        with client.create(toutatis.scene(DATA, method, toutatis.HOUR)) as session:
            attitudes.append(session.trajectory(to=toutatis.DAYS * 24, every=24, fields="Q")["Q"])
    # For a small angle a, |Q - Q_exact| in the Frobenius norm is sqrt(2) a.
    angles = np.degrees(np.linalg.norm(attitudes[0] - attitudes[1], axis=(1, 2)) / np.sqrt(2))
    assert np.allclose(rk4.error[1:], angles[1:], rtol=1e-6) and rk4.method == "rk4 of order 4"


def test_the_main_run_has_the_recommended_method(session, client):
    assert "method" not in toutatis.scene(DATA) and session.scene["method"]["name"] == "exact"
    assert toutatis.error_in_degrees(session.diagnose(to=toutatis.DAYS * toutatis.DAY, estimate_error=True)) < 1e-8


def test_an_error_below_that_of_the_reference_is_drawn_as_zero():
    estimate = stiefel.EstimatedError(attitude=None, momentum=None, angle=None, reference_error=1.1e-16, reference="Jacobi",
                                      work=1, run_work=1, missing="the error is below that of the reference", member=None)
    assert toutatis.error_in_degrees(SimpleNamespace(estimated_error=estimate)) == 0
    with pytest.raises(AssertionError):
        toutatis.error_in_degrees(SimpleNamespace(estimated_error=replace(estimate, reference="")))


def run(script, *arguments, folder):
    return subprocess.run([sys.executable, EXAMPLES / script, *arguments], cwd=folder, capture_output=True,
                          text=True, env={**os.environ, "MPLCONFIGDIR": str(folder)})


def test_the_command(tmp_path):
    result = run("toutatis.py", "--output", "out", folder=tmp_path)
    assert result.returncode == 0, result.stderr
    rows = re.findall(r"^1992-12-\S+ +([\d.]+) +([\d.]+) +([\d.]+)$", result.stdout, re.MULTILINE)
    assert len(rows) == 17
    median = float(re.search(r"^median ([\d.]+), worst", result.stdout, re.MULTILINE)[1])
    assert median == pytest.approx(np.median(np.array(rows, dtype=float)), abs=0.01)
    assert re.search(r"^5617 states in \S+ s, with the method exact$", result.stdout, re.MULTILINE)
    assert re.search(r"^estimated error of the last attitude: \S+e-\d\d degrees$", result.stdout, re.MULTILINE)
    assert re.search(r"^variational of order 2 +1\.\de-16 +3\.9e\+00 degrees$", result.stdout, re.MULTILINE)
    assert re.search(r"^recommended: exact +\S+ +\S+e-1\d degrees$", result.stdout, re.MULTILINE)
    with np.load(tmp_path / "out" / "trajectory.npz") as saved:
        assert saved["step"][-1] == 39 * 86400 and saved["Q"].shape == (5617, 3, 3)
    assert (tmp_path / "out" / "toutatis.png").read_bytes().startswith(b"\x89PNG")


def test_the_sentence_of_the_page_about_literature(session):
    page = " ".join((EXAMPLES.parents[1] / "docs/literature.md").read_text(encoding="utf-8").replace("\n>", "").split())
    median, count, most, bound = map(float, re.search(
        r"are (\S+) degrees from those of the (\d+) observed .* median, and (\S+) degrees at most; .* below (\S+) degrees", page).groups())
    angles = np.array([one.angles() for one in toutatis.compare(session, DATA)])
    error = toutatis.error_in_degrees(session.diagnose(to=toutatis.DAYS * toutatis.DAY, estimate_error=True))
    assert (len(angles), round(np.median(angles), 2), round(angles.max(), 2)) == (count, median, most) and error < bound


def test_a_user_s_scene(tmp_path):
    scene = {"system": "moser_veselov", "inertia": [1, 2, 3, 4], "step": 0.05,
             "initial": {"Q": {"rows": 4, "cols": 4, "values": np.eye(4).ravel().tolist()},
                         "M": {"rows": 4, "cols": 4, "values": [0, 1, 2, 0, -1, 0, 1, 1, -2, -1, 0, 3, 0, -1, -3, 0]}}}
    (tmp_path / "scene.json").write_text(json.dumps(scene))
    result = run("run_scene.py", "scene.json", "--steps", "5000", "--output", "out", folder=tmp_path)
    assert result.returncode == 0, result.stderr
    assert "REACHED at step 5000" in result.stdout and "spatial_momentum" in result.stdout
    assert "estimated error at step 5000: none: moser_veselov is a discrete system" in result.stdout
    assert (tmp_path / "out" / "scene.png").exists() and (tmp_path / "out" / "trajectory.npz").exists()


def test_a_drift_does_not_stand_alone(tmp_path):
    (tmp_path / "scene.json").write_text(json.dumps({
        "system": "rigid_body", "method": {"name": "variational"}, "step": 0.1,
        "body": {"moments": [1, 2, 2.7], "angular_velocity": [0.3, 1, 0.2]}}))
    result = run("run_scene.py", "scene.json", "--steps", "1000", "--output", "out", folder=tmp_path)
    assert result.returncode == 0, result.stderr
    shown = re.search(r"^estimated error at step 1000: attitude (\S+), momentum (\S+) from Jacobi's", result.stdout, re.MULTILINE)
    assert 0.01 < float(shown[1]) < 1 and 0.01 < float(shown[2]) < 1


@pytest.mark.parametrize("scene, status, words", [
    ({"system": "rigid_boddy", "step": 1}, 2, "system.*rigid_boddy"),
    ({"sytem": "rigid_body"}, 2, "sytem"),
    ({"system": "rigid_body", "method": {"name": "variational"}, "step": 20,
      "body": {"moments": [1, 2, 3], "angular_velocity": [1, 1, 1]}}, 3, "LEFT_DOMAIN at step 0"),
])
def test_a_scene_that_does_not_work(tmp_path, scene, status, words):
    (tmp_path / "scene.json").write_text(json.dumps(scene))
    result = run("run_scene.py", "scene.json", "--steps", "100", folder=tmp_path)
    assert result.returncode == status, result.stderr
    assert re.search(words, result.stdout + result.stderr)
    assert "Traceback" not in result.stderr
