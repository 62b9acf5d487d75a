"""A saved trajectory has the arrays of the file that the command writes; it is read back and run again to the last bit."""
import json
import os
import subprocess
from pathlib import Path

import numpy as np
import pytest

import stiefel
from stiefel._results.save import number

BODY = {"system": "rigid_body", "method": {"name": "variational"}, "step": 0.01,
        "body": {"moments": [1, 2, 3], "angular_velocity": [0.1, 2, 0.1]}}
SCENES = {
    "body": BODY,
    "ensemble": {**BODY, "members": 2, "body": {"moments": [1, 2, 3], "angular_velocity": [0.1, 2, 0.1, 30, 1, 0.25]}},
    "complex": {"system": "double_bracket", "method": {"name": "rk4"}, "step": 0.01, "inertia_u": [1, 2], "inertia_v": [3],
                "initial": {"Q": np.array([[1], [0.5j]]), "P": np.array([[0.2j], [1 + 1e-7j]])}},
    "stopped": {**BODY, "step": 5.0},
}


@pytest.fixture(scope="session")
def command():
    path = Path(os.environ.get("STIEFEL_CLI") or Path(stiefel.server.find_server()).with_name("stiefel"))
    if not path.exists():
        pytest.skip("the command is not built")
    return path


@pytest.fixture(params=SCENES)
def scene(request):
    return SCENES[request.param]


@pytest.fixture
def run(client, scene):
    with client.create(scene) as session:
        return session.trajectory(to=20, every=3)


def written(command, scene, folder, suffix):
    (folder / "scene.json").write_text(json.dumps(stiefel.to_dict(scene)))
    file = folder / f"command{suffix}"
    subprocess.run([command, "run", folder / "scene.json", "--to", "20", "--every", "3", "--output", file],
                   capture_output=True)
    return file


def described(run, text):
    """The JSON of a description. The distance of two samples is not known of a run that has one."""
    found = json.loads(text)
    if len(run) < 2 and "run" in found:
        del found["run"]["every"]
    return found


def test_npz(command, scene, run, tmp_path):
    run.save(tmp_path / "run.npz")
    with np.load(tmp_path / "run.npz") as ours, np.load(written(command, scene, tmp_path, ".npz")) as theirs:
        assert list(ours) == list(theirs) == ["step", "time", *run.fields, "stiefel"]
        for name in list(ours)[:-1]:
            assert ours[name].dtype == theirs[name].dtype
            np.testing.assert_array_equal(ours[name], theirs[name])


def test_csv(command, scene, run, tmp_path):
    run.save(str(tmp_path / "run.csv"))
    ours, theirs = (path.read_text().splitlines() for path in (tmp_path / "run.csv", written(command, scene, tmp_path, ".csv")))
    assert ours[1:-1] == theirs[1:-1] and len(ours) == len(run) + 4 and ours[1].startswith("# units: 1,s")
    for one, other in ((ours[0], theirs[0]), (ours[-1], theirs[-1])):
        assert described(run, one[2:]).items() <= described(run, other[2:]).items()


def test_json(command, scene, run, tmp_path):
    run.save(tmp_path / "run.json")
    ours, theirs = (tmp_path / "run.json").read_text(), written(command, scene, tmp_path, ".json").read_text()
    samples, _, rest = ours.partition("],\n  \"outcome\"")
    assert theirs.partition("],\n  \"outcome\"")[0] == samples and rest
    ours, theirs = described(run, ours), described(run, theirs)
    assert {name: theirs[name] for name in ours} == ours and ours["outcome"] == run.outcome


@pytest.mark.parametrize("name", ["run", "run.txt", "run.npz.gz", "csv"])
def test_another_end_is_refused(run, tmp_path, name):
    with pytest.raises(ValueError, match=r"must end in \.npz, \.csv, \.json, \.h5, \.hdf5, \.zarr or \.parquet"):
        run.save(tmp_path / name)
    assert list(tmp_path.iterdir()) == []


def test_no_half_of_a_file_is_left(client, tmp_path):
    with client.create(BODY) as session:
        run = session.trajectory(to=20)
    run.save(tmp_path / "run.json")
    before = (tmp_path / "run.json").read_text()
    run.fields["broken"] = None
    with pytest.raises(TypeError):
        run.save(tmp_path / "run.json")
    assert [file.name for file in tmp_path.iterdir()] == ["run.json"]
    assert (tmp_path / "run.json").read_text() == before


@pytest.mark.parametrize("value, text", [
    (0.0, "0.0"), (-0.0, "-0.0"), (3.0, "3.0"), (1e22, "1e+22"), (5e-324, "5e-324"), (100000.0, "1e+05"),
    (120000.0, "120000.0"), (1e4, "10000.0"), (0.001, "0.001"), (0.0001, "1e-04"), (0.00012, "0.00012"),
    (0.000012, "1.2e-05"), (-1234567.25, "-1234567.25"), (123456789012345680.0, "123456789012345680.0"), (1e-300, "1e-300"),
])
def test_numbers_are_the_command_s(value, text):
    assert number(value) == text


def test_numbers_read_back():
    rng = np.random.default_rng(1)
    for value in rng.integers(0, 2**63, 20_000).view(np.float64).tolist():
        if np.isfinite(value):
            assert float(number(value)) == value


def test_nan_is_null_in_json(tmp_path):
    """As of a member that has stopped. JSON has neither NaN nor the infinities."""
    def refuse(constant):
        raise ValueError(f"{constant} is not JSON")

    values = np.array([[[1.5, np.nan]], [[-np.inf, np.inf]]])
    status = stiefel.RunStatus(stiefel.Outcome.LEFT_DOMAIN, largest_step=np.inf)
    stiefel.Trajectory(np.arange(2), np.array([0.0, np.nan]), {"x": values}, status, 0).save(tmp_path / "run.json")
    found = json.loads((tmp_path / "run.json").read_text(), parse_constant=refuse)
    assert [sample["fields"]["x"] for sample in found["samples"]] == [[[1.5, None]], [[None, None]]]
    assert [sample["time"] for sample in found["samples"]] == [0.0, None] and "largest_step" not in found
