"""What a sweep returns: the same numbers as each motion alone, however it is spread, in the order of the grid."""
import hashlib
import json
import multiprocessing
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor

import numpy as np
import pytest
from cases import AXES, MOMENTS, SCENE, SPINS, TO, can_fork, failures, plain_result, small_chunks, sweep  # noqa: F401

import stiefel

SPAWN = multiprocessing.get_context("spawn")


def alone(client, scene, to=TO, fields="quaternion"):
    with client.create(scene) as session:
        return session.trajectory(to=to, fields=fields)


def test_each_motion_has_the_bits_that_it_has_alone(client, small_chunks):
    found = sweep(axes={"body.moments": MOMENTS[:5], "body.angular_velocity": SPINS[:4]}, zipped=False)
    assert found["quaternion.last"].shape == (5, 4, 4) and found.attrs["chunks"] == 5
    for i, j in np.ndindex(5, 4):
        run = alone(client, {**SCENE, "body": {"moments": MOMENTS[i], "angular_velocity": SPINS[j]}})
        assert found["quaternion.last"].values[i, j].tobytes() == run["quaternion"][-1].tobytes()
        assert np.array_equal(found["quaternion.max"][i, j], run["quaternion"].max(axis=0))
    assert (found["outcome"] == 1).all() and (found["last_step"] == TO).all()
    assert 0 < float(found["energy.drift"].max()) < 1e-13


def test_the_bytes_do_not_depend_on_who_computes_them(client, small_chunks):
    hashes = {"here": sweep().attrs["sha256"], "one thread": sweep(threads=1).attrs["sha256"],
              "a server": sweep(servers=[client.address]).attrs["sha256"],
              "a client": sweep(servers=[client, client.address]).attrs["sha256"]}
    with ThreadPoolExecutor(3) as threads:
        hashes["threads"] = sweep(executor=threads).attrs["sha256"]
    for workers in (1, 2, 4):
        with ProcessPoolExecutor(workers, mp_context=SPAWN) as pool:
            hashes[f"{workers} processes"] = sweep(executor=pool).attrs["sha256"]
    if can_fork():
        with ProcessPoolExecutor(2, mp_context=multiprocessing.get_context("fork")) as pool:
            hashes["forked processes"] = sweep(executor=pool).attrs["sha256"]
    assert len(set(hashes.values())) == 1, hashes
    assert not client.closed


def test_the_bytes_do_not_depend_on_the_chunks(monkeypatch):
    one = sweep()
    monkeypatch.setattr("stiefel._sweep.chunks.LARGEST", 7)
    many = sweep()
    assert (one.attrs["chunks"], many.attrs["chunks"]) == (1, 9)
    assert one.attrs["sha256"] == many.attrs["sha256"]


OVER = {"M": {"statistics": ["min", "max", "mean", "rms", "sign_changes", "drift"], "edges": [-4, -1, 0, 1, 4], "over_members": True},
        "energy": {"statistics": ["mean", "drift"], "over_members": True}}


def test_statistics_over_all_motions_are_combined_here_in_the_order_of_the_points(client, small_chunks, plain_result):
    found = sweep(summarize={**OVER, "quaternion": ["last"]})
    scene = {**SCENE, "members": 60, "body": {"moments": MOMENTS, "angular_velocity": SPINS}}
    with client.create(scene) as session:
        summary = session.summarize(TO, OVER)
    assert found["quaternion.last"].shape == (60, 4) and "samples" not in found and found.variables["M.mean"][0] == ("M_row", "M_col")
    for name in ("min", "max", "sign_changes", "histogram", "drift"):
        assert np.array_equal(found[f"M.{name}"], summary["M"][name]), name
        assert found[f"M.{name}"].dtype == summary["M"][name].dtype
    for name in ("mean", "rms"):
        np.testing.assert_allclose(found[f"M.{name}"], summary["M"][name], rtol=1e-13, atol=1e-15)
    np.testing.assert_allclose(found["energy.mean"], summary["energy"]["mean"], rtol=1e-14)
    assert found["energy.drift"] == summary["energy"]["drift"] and found["energy.drift"].shape == ()


def test_their_bytes_do_not_depend_on_the_chunks(monkeypatch, tmp_path):
    hashes = set()
    for largest in (1 << 14, 16, 7):
        monkeypatch.setattr("stiefel._sweep.chunks.LARGEST", largest)
        hashes.add(sweep(summarize=OVER).attrs["sha256"])
    hashes.add(sweep(summarize=OVER, store=tmp_path / "store").attrs["sha256"])
    hashes.add(sweep(summarize=OVER, store=tmp_path / "store").attrs["sha256"])
    assert len(hashes) == 1


def test_motions_that_end_early_weigh_less(client, plain_result):
    found = sweep(axes={"body.angular_velocity[1]": [0.5, 60.0]}, summarize={"M": {"statistics": ["mean"], "over_members": True}},
                  scene={**SCENE, "step": 0.1})
    each = sweep(axes={"body.angular_velocity[1]": [0.5, 60.0]}, summarize={"M": {"statistics": ["mean"]}}, scene={**SCENE, "step": 0.1})
    counts = each["last_step"] + 1
    assert counts[1] < counts[0] == TO + 1
    np.testing.assert_allclose(found["M.mean"], (each["M.mean"] * counts[:, None, None]).sum(0) / counts.sum(), rtol=1e-14, atol=1e-16)


def test_the_hash_is_that_of_the_bytes():
    found = sweep(axes={"step": [0.01, 0.02]}, zipped=False)
    digest = hashlib.sha256()
    for part in (found.coords, found.data_vars):
        for name in sorted(part):
            values = part[name].values
            digest.update(f"{name} {values.dtype.str} {values.shape}\n".encode() + values.tobytes())
    assert found.attrs["sha256"] == digest.hexdigest()
    assert sweep(axes={"step": [0.01, 0.021]}, zipped=False).attrs["sha256"] != digest.hexdigest()


def test_fields_that_members_share_are_axes_too(client):
    """Their points are of different ensembles, and stand where they belong all the same."""
    axes = {"body.angular_velocity[1]": [0.5, 1.0, 1.5], "method.order": [2, 4], "step": [0.01, 0.02]}
    found = sweep(axes=axes, zipped=False)
    assert found["quaternion.last"].dims[:3] == tuple(axes) and found.attrs["chunks"] == 4
    assert found["method.order"].values.tolist() == [2, 4]
    for spin in axes["body.angular_velocity[1]"]:
        for order in (2, 4):
            for step in (0.01, 0.02):
                scene = {**SCENE, "step": step, "method": {"name": "variational", "order": order},
                         "body": {"moments": [1, 2, 3], "angular_velocity": [0.1, spin, 0.1]}}
                here = found.sel({"body.angular_velocity[1]": spin, "method.order": order, "step": step})
                assert here["quaternion.last"].values.tobytes() == alone(client, scene)["quaternion"][-1].tobytes()


def test_methods_by_name_are_an_axis():
    found = sweep(axes={"method.name": ["variational", "rk4", "exact"]}, zipped=False)
    drifts = found["energy.drift"].sel({"method.name": ["variational", "rk4"]}).values
    assert drifts[0] < 1e-14 < drifts[1]


def test_whole_methods_are_an_axis(client):
    given = [{"name": "rk4"}, {"name": "variational", "order": 4}, {"name": "variational", "order": 2, "substeps": 2}]
    found = sweep(axes={"method": given, "step": [0.02, 0.04]}, zipped=False)
    assert [json.loads(text) for text in found["method"].values] == given and found["quaternion.last"].shape == (3, 2, 4)
    for i, j in np.ndindex(3, 2):
        run = alone(client, {**SCENE, "method": given[i], "step": [0.02, 0.04][j]})
        assert np.array_equal(found["quaternion.last"].values[i, j], run["quaternion"][-1])


@pytest.mark.parametrize("axes, message", [
    ({"method": {"name": "rk4"}}, r"axes\['method'\]: .* must be names or mappings such as"),
    ({"method": 3}, "must be names or mappings such as"),
    ({"method": [{"name": "rk4"}, {"nme": "rk4"}]}, r"axes\['method'\]\[1\]: method.nme: unknown field; did you mean name"),
    ({"method": [{"name": "rk4"}], "method.order": [2]}, r"axes\['method'\]: method.order is an axis too"),
    ({"initial.M[0,1]": [1.0], "initial.M[1,0]": [2.0]}, r"initial.M\[1,0\] is an axis too"),
    ({"initial.M[1,1]": [1.0]}, "must be off the diagonal, because M is skew-symmetric"),
])
def test_methods_and_entries_that_do_not_fit(axes, message):
    scene = {"system": "rigid_body", "inertia": [2.5, 1.5, 0.5], "step": 0.01, "initial": {"M": np.zeros((3, 3))}}
    with pytest.raises(stiefel.InvalidArgument, match=message):
        sweep(scene=scene, axes=axes)


def test_an_entry_of_a_momentum_keeps_it_skew(client):
    scene = {"system": "rigid_body", "inertia": [2.5, 1.5, 0.5], "step": 0.01, "method": {"name": "variational"},
             "initial": {"Q": np.eye(3), "M": [[0, -0.3, 2], [0.3, 0, -0.2], [-2, 0.2, 0]]}}
    values = [0.1, -0.4, 0.7]
    found = sweep(scene=scene, axes={"initial.M[0,1]": values}, summarize={"M": ["last"]})
    for value, last in zip(values, found["M.last"].values):
        M = np.array([[0, value, 2], [-value, 0, -0.2], [-2, 0.2, 0]])
        assert np.array_equal(last, alone(client, {**scene, "initial": {"Q": np.eye(3), "M": M}}, fields="M")["M"][-1])


def test_blocks_and_common_blocks(client):
    """The axes set M; every member gets the scene's Q."""
    rng = np.random.default_rng(1)
    momenta = rng.normal(size=(6, 5, 5))
    momenta -= momenta.transpose(0, 2, 1)
    Q = np.linalg.qr(rng.normal(size=(5, 5)))[0]
    scene = {"system": "rigid_body", "step": 0.01, "inertia": [1, 2, 3, 4, 5], "initial": {"Q": Q},
             "method": {"name": "variational"}}
    found = stiefel.sweep(scene, {"initial.M": momenta}, to=20, summarize={"Q": "last", "M": "last"})
    for k in range(6):
        run = alone(client, {**scene, "initial": {"Q": Q, "M": momenta[k]}}, 20, ["Q", "M"])
        for name in ("Q", "M"):
            assert found[f"{name}.last"].values[k].tobytes() == run[name][-1].tobytes()


def test_the_recommended_method_does_not_depend_on_the_chunks(monkeypatch):
    """All points get the substeps of the most demanding one, which is in the last chunk."""
    scene = {name: value for name, value in SCENE.items() if name != "method"}
    spins = np.outer(np.linspace(0.1, 300, 12), [0.1, 1, 0.1])
    one = sweep(scene=scene, axes={"body.angular_velocity": spins})
    monkeypatch.setattr("stiefel._sweep.choices.LARGEST", 5)
    monkeypatch.setattr("stiefel._sweep.chunks.LARGEST", 2)
    many = sweep(scene=scene, axes={"body.angular_velocity": spins})
    assert json.loads(one.attrs["scene"])["method"]["substeps"] > 1
    assert one.attrs["sha256"] == many.attrs["sha256"] and many.attrs["chunks"] == 6


def test_a_motion_that_leaves_its_domain_is_data(client, small_chunks):
    spins = SPINS.copy()
    spins[[5, 6, 41]] *= 1000
    found = sweep(axes={"body.moments": MOMENTS, "body.angular_velocity": spins})
    codes = json.loads(found.attrs["outcomes"])
    assert np.flatnonzero(found["outcome"] == codes["LEFT_DOMAIN"]).tolist() == [5, 6, 41]
    assert (found["last_step"].values[[5, 6, 41]] < TO).all()
    whole, others = sweep(), np.setdiff1d(np.arange(60), [5, 6, 41])
    assert np.array_equal(found["quaternion.last"][others], whole["quaternion.last"][others])


def test_the_attributes_make_the_sweep_again():
    """The scene there, completed by the coordinates, is the scene of any point."""
    scene = {name: value for name, value in SCENE.items() if name != "method"}
    found = sweep(scene=scene)
    again = json.loads(found.attrs["scene"])
    assert again["method"]["name"] and "angular_velocity" not in again["body"]
    repeated = sweep(scene=again, axes={name: found[name].values for name in AXES})
    assert repeated.attrs["sha256"] == found.attrs["sha256"]
    assert found.attrs["build"].startswith("sources ") and len(found.attrs["numerics_id"]) == 16


def test_without_xarray_the_result_has_the_same_content(plain_result):
    plain = sweep()
    assert isinstance(plain, stiefel.SweepResult)
    assert sorted(plain) == ["energy.drift", "last_step", "outcome", "quaternion.last", "quaternion.max"]
    assert plain["quaternion.last"].shape == (60, 4) and np.array_equal(plain["body.moments"], MOMENTS)
    assert plain == sweep() and "energy.drift (60,)" in repr(plain)
    with pytest.raises(KeyError, match="no 'energy'; there are energy.drift"):
        plain["energy"]


def test_no_failures_are_counted_where_there_are_none():
    assert failures(sweep()) == {}
