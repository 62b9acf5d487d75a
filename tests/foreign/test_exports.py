"""Files of trajectories read by others: attitude messages by Orekit, every other format by the packages that PyPI has now."""
from __future__ import annotations

import json
import subprocess
from pathlib import Path
from typing import Any

import numpy as np

import stiefel
from tools import from_pypi

SCENE = {"system": "rigid_body", "step": 0.1, "epoch": "2026-03-01T23:59:58.25 UTC", "body": {
    "inertia_tensor": [2.0, 3, 4, 0.1, 0.05, -0.2], "angular_velocity": [0.3, 1, 0.2], "attitude": [0.5, -0.5, 0.5, 0.5]}}
LEAPS = " 1972 JAN  1 =JD 2441317.5  TAI-UTC=  10.0       S + (MJD - 41317.) X 0.0      S\n" \
        " 2017 JAN  1 =JD 2457754.5  TAI-UTC=  37.0       S + (MJD - 41317.) X 0.0      S\n"


def angle_between(first: Any, second: Any) -> Any:
    """The angles in radians between attitudes as unit quaternions."""
    return 4 * np.arcsin(np.minimum(np.linalg.norm(first - second, axis=-1), np.linalg.norm(first + second, axis=-1)) / 2)


def test_orekit_reads_attitude_messages(server: stiefel.Server, tmp_path: Path) -> None:
    programs = from_pypi("orekit")
    (tmp_path / "tai-utc.dat").write_text(LEAPS)
    with stiefel.Client(server.address) as client, client.create(SCENE) as session:
        run = session.trajectory(to=60, fields=["quaternion", "angular_velocity"])
        true = session.trajectory(times=run.time[:-1] + 0.05, fields="quaternion")["quaternion"]
        alone = session.trajectory(to=60, fields="quaternion")
    run.to_aem(tmp_path / "run.aem", object_id="2026-001A")
    alone.to_aem(tmp_path / "quaternions.aem", object_id="2026-001A")
    reads = Path(__file__).with_name("orekit_reads.py")
    done = subprocess.run([programs / "python", reads, tmp_path], capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    found: dict[str, Any] = json.loads(done.stdout)
    assert found["start"] == "2026-03-01T23:59:58.250Z" and np.allclose(found["times"], run.time, rtol=0, atol=1e-12)
    assert angle_between(np.array(found["nodes"]), run["quaternion"]).max() < 1e-12
    # With angular velocities Orekit interpolates to the fourth order in the angle of 0.1 rad between samples, else to the second.
    assert 0 < angle_between(np.array(found["between"]), true).max() < 0.1**4
    assert 0 < angle_between(np.array(found["between_quaternions"]), true).max() < 0.1**2
    assert "ANGVEL" not in (tmp_path / "quaternions.aem").read_text()


def test_every_format_with_the_packages_of_today(start: Any) -> None:
    """The client's own tests of files, none of which may be skipped."""
    programs, tests = from_pypi("files"), Path(__file__).resolve().parents[1] / "python/results"
    done = subprocess.run([programs / "python", "-m", "pytest", "-q", "-rs", "-p", "no:cacheprovider", tests / "test_files.py",
                           tests / "test_exports.py"], capture_output=True, text=True, timeout=1200)
    assert done.returncode == 0 and "skipped" not in done.stdout, done.stdout[-4000:]
