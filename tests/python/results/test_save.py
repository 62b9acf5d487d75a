"""A saved trajectory has the numbers of its arrays to the last bit, in every format."""
import csv
import json

import numpy as np
import pytest

import stiefel

BODY = {"system": "rigid_body", "method": {"name": "variational"}, "step": 0.01,
        "body": {"moments": [1, 2, 3], "angular_velocity": [0.1, 2, 0.1]}}
SCENES = {
    "body": BODY,
    "ensemble": {**BODY, "members": 2, "body": {"moments": [1, 2, 3], "angular_velocity": [0.1, 2, 0.1, 30, 1, 0.25]}},
    "complex": {"system": "double_bracket", "method": {"name": "rk4"}, "step": 0.01, "inertia_u": [1, 2], "inertia_v": [3],
                "initial": {"Q": np.array([[1], [0.5j]]), "P": np.array([[0.2j], [1 + 1e-7j]])}},
    "stopped": {**BODY, "step": 5.0},
}


@pytest.fixture(params=SCENES)
def scene(request):
    return SCENES[request.param]


@pytest.fixture
def run(client, scene):
    with client.create(scene) as session:
        return session.trajectory(to=20, every=3)


def numbers(values):
    """The numbers of one sample of a field in the order of a table."""
    flat = np.ascontiguousarray(values).ravel()
    return flat.view(float).tolist() if np.iscomplexobj(flat) else flat.tolist()


def test_npz(run, tmp_path):
    run.save(tmp_path / "run.npz")
    with np.load(tmp_path / "run.npz") as saved:
        assert list(saved) == ["step", "time", *run.fields, "stiefel"]
        for name, values in {"step": run.step, "time": run.time, **run.fields}.items():
            assert saved[name].dtype == values.dtype and np.array_equal(saved[name], values)


def test_csv(run, tmp_path):
    run.save(str(tmp_path / "run.csv"))
    first, units, *table, last = (tmp_path / "run.csv").read_text().splitlines()
    names, *rows = csv.reader(table)
    assert units.startswith("# units: 1,s") and len(units.split(",")) == len(names) and names[:2] == ["step", "time"]
    assert json.loads(first[2:])["scene"] == run.scene and json.loads(last[2:])["outcome"] == run.outcome
    assert [[float(cell) for cell in row] for row in rows] == [
        [step, time, *(number for values in run.fields.values() for number in numbers(values[k]))]
        for k, (step, time) in enumerate(zip(run.step, run.time))]


def test_json(run, tmp_path):
    run.save(tmp_path / "run.json")
    saved = json.loads((tmp_path / "run.json").read_text())
    assert saved["outcome"] == run.outcome and saved["scene"] == run.scene and len(saved["samples"]) == len(run)
    for k, sample in enumerate(saved["samples"]):
        assert (sample["step"], sample["time"]) == (run.step[k], run.time[k])
        for name, found in sample["fields"].items():
            complex_ = np.array(found["values"]) + 1j * np.array(found["imaginary"]) if isinstance(found, dict) else np.array(found)
            assert np.array_equal(complex_, run.fields[name][k])


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
