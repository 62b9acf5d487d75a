"""Every format: written, read and run again, with the same arrays to the last bit; and the tables of other packages."""
import json
import pickle

import numpy as np
import pytest

import stiefel

BODY = {"system": "rigid_body", "method": {"name": "variational"}, "step": 0.01, "epoch": "2026-03-01T12:00:00 UTC",
        "body": {"moments": [1, 2, 3], "angular_velocity": [0.1, 2, 0.1]}}
FRAME = {"system": "stiefel", "step": 0.1, "inertia": [1, 2, 3], "initial": {"Q": [[1, 0, 0]], "S": [[0, 0.3, 1]]}}
SCENES = {
    "body": (BODY, dict(to=20, every=3, fields=["quaternion", "angular_velocity", "momentum_space", "M"])),
    "one sample": (BODY, dict(to=7, start=7)),
    "times on both sides": (BODY, dict(times=[0.1, -0.033, 0.0, 0.025])),
    "up to a time": (BODY, dict(time=0.077, every=2)),
    "in float": ({**BODY, "method": {"name": "variational", "scalar": "float"}}, dict(to=9)),
    "ensemble": ({**BODY, "members": 2, "body": {"moments": [1, 2, 3], "angular_velocity": [0.1, 2, 0.1, 30, 1, 0.25]}}, dict(to=9)),
    "a frame of one row": (FRAME, dict(to=9)),
    "epsilon": ({"system": "symmetric_rigid_body", "step": 0.1, "inertia": [1, 2, 3],
                 "initial": {"Q": np.eye(3), "M": [[0, 1, 2], [-1, 0, 3], [-2, -3, 0]]}}, dict(to=3, fields=["epsilon", "M"])),
    "complex": ({"system": "double_bracket", "method": {"name": "rk4"}, "step": 0.01, "inertia_u": [1, 2], "inertia_v": [3],
                 "initial": {"Q": np.array([[1], [0.5j]]), "P": np.array([[0.2j], [1 + 1e-7j]])}}, dict(to=9)),
    "stopped": ({**BODY, "step": 1.5, "method": {"name": "rk4"}}, dict(to=1000, every=2)),
    "stopped before a time": ({**BODY, "step": 1.5, "method": {"name": "rk4"}}, dict(times=[1.0, 20.0, 900.0])),
}
FORMATS = [".npz", ".csv", ".json"]


def same_bits(one, other):
    assert one == other and list(one.fields) == list(other.fields)
    for name in one.fields:
        assert one[name].dtype == other[name].dtype and one[name].shape == other[name].shape, name
        assert np.ascontiguousarray(one[name]).tobytes() == np.ascontiguousarray(other[name]).tobytes(), name
    assert one.time.tobytes() == other.time.tobytes() and one.step.dtype == other.step.dtype == np.int64


@pytest.mark.parametrize("name", SCENES)
def test_written_read_and_run_again(client, tmp_path, name):
    scene, arguments = SCENES[name]
    with client.create(scene) as session:
        run = session.trajectory(**arguments, estimate_error=True)
    assert run.outcome == ("NOT_FINITE" if name.startswith("stopped") else "REACHED") and run.estimated_error is not None
    for suffix in FORMATS:
        file, copy = tmp_path / f"run{suffix}", tmp_path / f"again{suffix}"
        run.save(file)
        loaded = stiefel.load(file)
        same_bits(run, loaded)
        assert loaded.scene == run.scene and loaded.build == run.build == client.describe().numerics_id
        assert loaded.epoch == run.epoch and loaded.units == run.units and loaded.estimated_error == run.estimated_error
        loaded.save(copy)
        assert copy.read_bytes() == file.read_bytes()
    again = stiefel.rerun(file, client)
    same_bits(again, run)
    assert again.estimated_error == run.estimated_error
    for part in (slice(2, None), slice(None, -1), slice(None, None, -1)) if name in ("body", "stopped") else ():
        run[part].save(file)
        same_bits(stiefel.rerun(file, client), run[part])


@pytest.mark.parametrize("name", ["body", "ensemble", "complex"])
def test_other_programs_read_the_numbers(client, tmp_path, name):
    """numpy, json and csv find the arrays without this package."""
    def numbers(values):
        return np.ascontiguousarray(values).reshape(len(values), -1).view(float)

    with client.create(SCENES[name][0]) as session:
        run = session.trajectory(**SCENES[name][1])
    for suffix in FORMATS:
        run.save(str(tmp_path / f"run{suffix}"))
    with np.load(tmp_path / "run.npz") as saved:
        assert list(saved) == ["step", "time", *run.fields, "stiefel"] and all((saved[name] == values).all() for name, values in run.fields.items())
    first, units, names, *rows = (tmp_path / "run.csv").read_text().splitlines()
    described = json.loads(first[2:])
    assert described["scene"] == run.scene and described["outcome"] == run.outcome and names.startswith("step,time,")
    assert units.startswith("# units: 1,s") and len(units.split(",")) == len(rows[0].split(","))
    table = np.array([row.split(",")[:-1] if run.utc is not None else row.split(",") for row in rows], float)
    assert (table == np.column_stack([run.step, run.time, *map(numbers, run.fields.values())])).all()
    saved = json.loads((tmp_path / "run.json").read_text())
    assert saved["scene"] == run.scene and [(one["step"], one["time"]) for one in saved["samples"]] == list(zip(run.step, run.time))
    for field, values in run.fields.items():
        found = [one["fields"][field] for one in saved["samples"]]
        found = [np.array(one["values"]) + 1j * np.array(one["imaginary"]) for one in found] if np.iscomplexobj(values) else found
        assert (np.array(found) == values).all(), field


def test_numbers_that_json_lacks_are_null_there(tmp_path):
    """As of a member that has stopped. No samples are a file, too."""
    def refuse(constant):
        raise ValueError(f"{constant} is not JSON")

    values = np.array([[[1.5, np.nan]], [[-np.inf, np.inf]]])
    status = stiefel.RunStatus(stiefel.Outcome.LEFT_DOMAIN, largest_step=np.inf)
    run = stiefel.Trajectory(np.arange(2), np.array([0.0, np.nan]), {"x": values}, status)
    for suffix in FORMATS:
        run.save(tmp_path / f"run{suffix}")
        expected = np.where(np.isfinite(values), values, np.nan) if suffix == ".json" else values
        assert np.array_equal(stiefel.load(tmp_path / f"run{suffix}")["x"], expected, equal_nan=True)
        with pytest.raises(ValueError, match="does not hold the scene"):
            stiefel.rerun(tmp_path / f"run{suffix}")
    found = json.loads((tmp_path / "run.json").read_text(), parse_constant=refuse)
    assert [one["fields"]["x"] for one in found["samples"]] == [[[1.5, None]], [[None, None]]] and "largest_step" not in found
    for suffix in (".npz", ".csv"):  # JSON has the shapes of its samples
        run[:0].save(tmp_path / f"none{suffix}")
        assert stiefel.load(tmp_path / f"none{suffix}")["x"].shape == (0, 1, 2)


def test_no_half_of_a_file_is_left(client, tmp_path):
    run = stiefel.simulate(BODY, to=20)
    pickle.loads(pickle.dumps(run)).save(tmp_path / "run.json")
    same_bits(stiefel.rerun(tmp_path / "run.json"), run)
    before = (tmp_path / "run.json").read_text()
    run.fields["broken"] = None
    with pytest.raises(TypeError):
        run.save(tmp_path / "run.json")
    with pytest.raises(ValueError, match=r"run.h5: must end in \.npz, \.csv or \.json; `to_xarray` and `to_dataframe` lead to other formats"):
        run.save(tmp_path / "run.h5")
    assert [file.name for file in tmp_path.iterdir()] == ["run.json"] and (tmp_path / "run.json").read_text() == before


@pytest.mark.parametrize("name, content", [("a.npz", b"PK\x03\x04"), ("a.json", b'{"samples": []}'), ("a.json", b'{"samples": ['),
                                           ("a.csv", b"step,time\n0,1.0\n"), ("a.csv", b"a,b\n1,2\n")])
def test_another_file_is_refused(tmp_path, name, content):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(ValueError, match=f"{name}: is not a file of a trajectory"):
        stiefel.load(tmp_path / name)
    with pytest.raises(ValueError, match="run.txt: must end in"):
        stiefel.load(tmp_path / "run.txt")
    with pytest.raises(FileNotFoundError):
        stiefel.load(tmp_path / "none.npz")
    stiefel.simulate(BODY, to=3).save(tmp_path / "run.csv")
    with pytest.raises(stiefel.InvalidArgument, match="; stiefel.load and stiefel.rerun read a file of samples$"):
        stiefel.simulate(tmp_path / "run.csv", to=3)


def test_tables_of_pandas_and_xarray(client, tmp_path):
    pandas = pytest.importorskip("pandas")
    pytest.importorskip("xarray")
    with client.create({**BODY, "members": 3}) as session:
        run = session.trajectory(to=4, fields=["quaternion", "angular_velocity", "Q"])
    one, data = run.member(1), run.to_xarray()
    one.save(tmp_path / "run.csv")
    read = pandas.read_csv(tmp_path / "run.csv", comment="#", float_precision="round_trip")
    assert list(read.columns[:9]) == ["step", "time", "q_w", "q_x", "q_y", "q_z", "omega_x", "omega_y", "omega_z"]
    ours = one.to_dataframe()
    assert list(ours.index) == list(run.time) and ours.attrs["units"]["omega_y"] == "rad/s" and ours.attrs["stiefel"]["scene"] == one.scene
    for frame in (read, ours):
        assert (frame["omega_y"].to_numpy() == one["angular_velocity"][:, 1]).all() and (frame["Q[2,0]"].to_numpy() == one["Q"][:, 2, 0]).all()
    assert data["quaternion"].dims == ("time", "member", "component") and data["Q"].dims == ("time", "member", "Q_row", "Q_col")
    assert data["angular_velocity"].attrs["units"] == "rad/s" and list(data["step"].values) == [0, 1, 2, 3, 4]
    assert float(data["angular_velocity"].sel(time=0, member=1, axis="y")) == pytest.approx(2, abs=1e-15)
    assert data.attrs["epoch"] == "2026-03-01T12:00:00 UTC" and data.attrs["outcome"] == "REACHED"
