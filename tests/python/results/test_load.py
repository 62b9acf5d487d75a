"""Every format: written, read and run again, with the same arrays to the last bit."""
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
    "from a step": (BODY, dict(to=20, start=5, every=4)),
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
SUFFIXES = {".npz": None, ".csv": None, ".json": None, ".h5": "h5py", ".zarr": "zarr", ".parquet": "pyarrow"}


@pytest.fixture(params=SUFFIXES)
def suffix(request):
    package = SUFFIXES[request.param]
    if package:
        pytest.importorskip(package, reason=f"{package} is not installed")
    return request.param


def same_bits(one, other):
    assert one == other and list(one.fields) == list(other.fields)
    for name in one.fields:
        assert one[name].dtype == other[name].dtype and one[name].shape == other[name].shape, name
        assert np.ascontiguousarray(one[name]).tobytes() == np.ascontiguousarray(other[name]).tobytes(), name
    assert one.time.tobytes() == other.time.tobytes() and one.step.dtype == other.step.dtype == np.int64


@pytest.mark.parametrize("name", SCENES)
def test_written_read_and_run_again(client, tmp_path, suffix, name):
    scene, arguments = SCENES[name]
    with client.create(scene) as session:
        run = session.trajectory(**arguments, estimate_error=True)
    if name.startswith("stopped"):
        assert run.outcome == "NOT_FINITE"
    file = tmp_path / f"run{suffix}"
    run.save(file)
    loaded = stiefel.load(file)
    same_bits(run, loaded)
    assert loaded.scene == run.scene and loaded.build == run.build == client.describe().numerics_id
    assert loaded.epoch == run.epoch and loaded.units == run.units and loaded.estimated_error == run.estimated_error
    again = stiefel.rerun(file, client)
    same_bits(again, run)
    assert again.estimated_error == run.estimated_error and (run.estimated_error is not None)
    loaded.save(tmp_path / f"again{suffix}")
    if suffix in (".npz", ".csv", ".json", ".parquet"):
        assert (tmp_path / f"again{suffix}").read_bytes() == file.read_bytes()
    loaded.save(file)  # a file, or the folder of a store, is replaced
    same_bits(stiefel.load(file), run)


@pytest.mark.parametrize("part", [slice(2, None), slice(None, -2), slice(None, None, 3), slice(4, 5), slice(None, None, -1)])
def test_a_part_can_be_run_again(client, tmp_path, part):
    for scene, arguments in (SCENES["body"], SCENES["stopped"]):
        with client.create(scene) as session:
            run = session.trajectory(**arguments)[part]
        run.save(tmp_path / "part.npz")
        same_bits(stiefel.rerun(tmp_path / "part.npz", client), run)


def test_it_runs_again_on_a_server_of_its_own(client, tmp_path):
    with client.create(BODY) as session:
        run = session.trajectory(to=5)
    pickle.loads(pickle.dumps(run)).save(tmp_path / "run.npz")
    same_bits(stiefel.rerun(tmp_path / "run.npz"), run)


def test_numbers_that_json_lacks_stay_in_the_other_formats(tmp_path, suffix):
    values = np.array([[[1.5, np.nan]], [[-np.inf, np.inf]]])
    run = stiefel.Trajectory(np.arange(2), np.array([0.0, 1.0]), {"x": values}, stiefel.RunStatus(stiefel.Outcome.REACHED))
    run.save(tmp_path / f"run{suffix}")
    expected = np.where(np.isfinite(values), values, np.nan) if suffix == ".json" else values
    assert np.array_equal(stiefel.load(tmp_path / f"run{suffix}")["x"], expected, equal_nan=True)
    with pytest.raises(ValueError, match="does not hold the scene"):
        stiefel.rerun(tmp_path / f"run{suffix}")


def test_no_samples_are_a_file_too(client, tmp_path, suffix):
    with client.create(BODY) as session:
        run = session.trajectory(to=5)[:0]
    run.save(tmp_path / f"run{suffix}")
    if suffix != ".json":  # JSON has the shapes of its samples
        same_bits(stiefel.load(tmp_path / f"run{suffix}"), run)


def test_another_file_is_refused(tmp_path):
    np.savez(tmp_path / "other.npz", x=np.eye(3))
    (tmp_path / "other.json").write_text('{"samples": []}')
    (tmp_path / "broken.json").write_text('{"samples": [')
    (tmp_path / "other.csv").write_text("step,time\n0,1.0\n")
    (tmp_path / "broken.npz").write_bytes(b"PK\x03\x04")
    (tmp_path / "broken.csv").write_text("a,b\n1,2\n")
    for name in ("other.npz", "other.json", "broken.json", "other.csv", "broken.npz", "broken.csv"):
        with pytest.raises(ValueError, match=f"{name}: is not a file of a trajectory"):
            stiefel.load(tmp_path / name)
    with pytest.raises(ValueError, match="must end in"):
        stiefel.load(tmp_path / "run.txt")
    with pytest.raises(FileNotFoundError):
        stiefel.load(tmp_path / "none.npz")


def test_a_missing_package_is_named(client, tmp_path, monkeypatch):
    import builtins
    import importlib

    found = importlib.import_module
    monkeypatch.setattr(importlib, "import_module", lambda name, *more: (_ for _ in ()).throw(ImportError(name)) if name == "h5py" else found(name, *more))
    with client.create(BODY) as session, pytest.raises(ImportError, match=r"h5py is needed for this: pip install 'stiefel\[hdf5\]'"):
        session.trajectory(to=1).save(tmp_path / "run.h5")
    assert builtins and list(tmp_path.iterdir()) == []


def test_a_table_reader_needs_no_help(client, tmp_path):
    pandas = pytest.importorskip("pandas", reason="python3-pandas is not installed")
    with client.create(BODY) as session:
        run = session.trajectory(to=20, every=3, fields=["quaternion", "angular_velocity", "Q"])
    run.save(tmp_path / "run.csv")
    frame = pandas.read_csv(tmp_path / "run.csv", comment="#", float_precision="round_trip")
    assert list(frame.columns[:9]) == ["step", "time", "q_w", "q_x", "q_y", "q_z", "omega_x", "omega_y", "omega_z"]
    assert (frame["omega_y"] == run["angular_velocity"][:, 1]).all() and (frame["Q[2,0]"] == run["Q"][:, 2, 0]).all()
    head, units, names = (tmp_path / "run.csv").read_text().splitlines()[:3]
    assert json.loads(head[2:])["scene"] == run.scene
    assert dict(zip(names.split(","), units[len("# units: "):].split(",")))["omega_z"] == "rad/s"
    ours = run.to_dataframe()
    assert list(ours.index) == list(run.time) and (ours["omega_y"].to_numpy() == run["angular_velocity"][:, 1]).all()
    assert ours.attrs["units"]["omega_y"] == "rad/s" and ours.attrs["stiefel"]["scene"] == run.scene


def test_a_dataset_of_xarray(client):
    pytest.importorskip("xarray", reason="python3-xarray is not installed")
    with client.create({**BODY, "members": 3}) as session:
        data = session.trajectory(to=4, fields=["quaternion", "angular_velocity", "Q"]).to_xarray()
    assert data["quaternion"].dims == ("time", "member", "component") and data["Q"].dims == ("time", "member", "Q_row", "Q_col")
    assert data["angular_velocity"].attrs["units"] == "rad/s" and list(data["step"].values) == [0, 1, 2, 3, 4]
    assert float(data["angular_velocity"].sel(time=0, member=1, axis="y")) == pytest.approx(2, abs=1e-15)
    assert data.attrs["epoch"] == "2026-03-01T12:00:00 UTC" and data.attrs["outcome"] == "REACHED"


def test_errors_at_times(client):
    with client.create(BODY) as session:
        run, one = session.trajectory(to=300, every=100), session.diagnose(to=200, estimate_error=True).estimated_error
        found = session.error_at([1.995, 0.0])
    assert list(found.step) == [200, 0] and found.attitude[0] == one.attitude and found.momentum[0] == one.momentum
    assert np.isnan(found.attitude[1]) and found.reference == one.reference and found.angle[0] == one.angle
    again = run.error_at()  # on a new session
    assert list(again.step) == [0, 100, 200, 300] and again.attitude[2] == one.attitude and len(repr(found).splitlines()) <= 3
    assert again.attitude[3] > again.attitude[1] > 0
    with client.create(BODY) as session, session.fork(at=0, step=-session.scene["step"]) as back:
        found = session.error_at([2.0, -1.995])
        before = back.diagnose(to=200, estimate_error=True).estimated_error
        run = session.trajectory(times=[-1.0, 1.0])
    assert list(found.step) == [200, -200] and list(found.attitude) == [one.attitude, before.attitude]
    assert np.isfinite(run.error_at().reference_error).all() and list(run.error_at().step) == [-100, 100]
    with client.create(BODY) as session, pytest.raises(stiefel.InvalidArgument, match="times"):
        session.error_at([[1.0]])


@pytest.mark.parametrize("suffix", [".npz", ".csv"])
def test_a_file_of_samples_is_no_scene(suffix, tmp_path):
    file = tmp_path / f"run{suffix}"
    stiefel.simulate(BODY, to=3).save(file)
    with pytest.raises(stiefel.InvalidArgument, match="; stiefel.load and stiefel.rerun read a file of samples$"):
        stiefel.simulate(file, to=3)
