"""What a sweep returns: the same numbers as each motion alone, however it is spread, in the order of the grid."""
import hashlib
import json
import os
import tempfile
import threading
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import psutil
import pytest
from cases import AXES, MOMENTS, SCENE, SPINS, TO, WITHOUT_METHOD, failures, methods, processes, small_chunks, sweep  # noqa: F401

import stiefel

SWEEPS = int(os.environ.get("STIEFEL_SHORT_SWEEPS", "12"))


def alone(client, scene, fields="quaternion"):
    """The motion and the method of a scene of its own."""
    with client.create(scene) as session:
        return session.trajectory(to=TO, fields=fields), session.scene.get("method")


def test_the_bytes_are_those_of_each_motion_alone_whoever_computes(client, small_chunks):
    """A motion that leaves the domain of its method is data."""
    spins = SPINS.copy()
    spins[[7, 41]] *= 1000
    axes = {**AXES, "body.angular_velocity": spins}
    found = sweep(axes=axes)
    left = json.loads(found.attrs["outcomes"])["LEFT_DOMAIN"]
    for k in range(0, 60, 7):
        run, _ = alone(client, {**SCENE, "body": {"moments": MOMENTS[k], "angular_velocity": spins[k]}})
        assert found["last_step"][k] == run.step[-1]
        assert found["quaternion.last"].values[k].tobytes() == run["quaternion"][-1].tobytes()
        assert np.array_equal(found["quaternion.max"][k], run["quaternion"].max(axis=0))
    assert np.flatnonzero(found["outcome"] == left).tolist() == [7, 41] and (found["outcome"] == 1).sum() == 58 and failures(found) == {}
    assert 0 < float(found["energy.drift"].max()) < 1e-13 and found.attrs["chunks"] == 15
    others = [sweep(axes=axes, threads=1), sweep(axes=axes, servers=[client, client.address])]
    with ThreadPoolExecutor(3) as threads, processes(2) as pool:
        others += [sweep(axes=axes, executor=threads), sweep(axes=axes, executor=pool, progress=True)]
    assert {one.attrs["sha256"] for one in others} == {found.attrs["sha256"]} and all(one.equals(found) for one in others)
    assert not client.closed


def test_the_hash_is_that_of_the_bytes_and_the_attributes_make_the_sweep_again(monkeypatch):
    found = sweep(scene=WITHOUT_METHOD)
    digest = hashlib.sha256()
    for part in (found.coords, found.data_vars):
        for name in sorted(part):
            values = part[name].values
            digest.update(f"{name} {values.dtype.str} {values.shape}\n".encode() + values.tobytes())
    assert found.attrs["sha256"] == digest.hexdigest() != sweep(to=TO + 1).attrs["sha256"]
    monkeypatch.setattr("stiefel._sweep.plan.LARGEST", 7)
    again = sweep(scene=json.loads(found.attrs["scene"]), axes={name: found[name].values for name in AXES},
                  summarize=json.loads(found.attrs["summarize"]))
    assert again.attrs["sha256"] == found.attrs["sha256"] and (found.attrs["chunks"], again.attrs["chunks"]) == (1, 9)
    assert methods(found)[0]["name"] and found.attrs["build"].startswith("sources ") and len(found.attrs["numerics_id"]) == 16


def test_a_grid_of_all_kinds_of_fields(client):
    """Points that differ in fields that members share are of different ensembles, and stand where they belong all the same."""
    given = ["rk4", {"name": "variational", "order": 4}]
    axes = {"body.angular_velocity[1]": [0.5, 1.0, 1.5], "method": given, "step": [0.01, 0.02]}
    found = sweep(axes=axes, zipped=False)
    assert found["quaternion.last"].dims[:3] == tuple(axes) and found.attrs["chunks"] == 4
    for i, j, k in np.ndindex(3, 2, 2):
        scene = {**SCENE, "step": axes["step"][k], "method": given[j],
                 "body": {"moments": [1, 2, 3], "angular_velocity": [0.1, axes["body.angular_velocity[1]"][i], 0.1]}}
        assert found["quaternion.last"].values[i, j, k].tobytes() == alone(client, scene)[0]["quaternion"][-1].tobytes()
    orders = sweep(axes={"method.order": [2, 4], "method.name": ["variational", "variational"]})
    assert orders["method.order"].values.tolist() == [2, 4] and orders["quaternion.last"].shape == (2, 4)


def test_blocks_and_common_blocks(client):
    """The axes set M; every member gets the scene's Q."""
    rng = np.random.default_rng(1)
    momenta = rng.normal(size=(6, 5, 5))
    momenta -= momenta.transpose(0, 2, 1)
    Q = np.linalg.qr(rng.normal(size=(5, 5)))[0]
    scene = {"system": "rigid_body", "step": 0.01, "inertia": [1, 2, 3, 4, 5], "initial": {"Q": Q},
             "method": {"name": "variational"}}
    found = sweep(scene=scene, axes={"initial.M": momenta}, summarize={"Q": "last", "M": "last"})
    for k in range(6):
        run, _ = alone(client, {**scene, "initial": {"Q": Q, "M": momenta[k]}}, ["Q", "M"])
        for name in ("Q", "M"):
            assert found[f"{name}.last"].values[k].tobytes() == run[name][-1].tobytes()


def test_the_recommended_method_is_that_of_the_most_demanding_point(client, monkeypatch):
    spins = np.outer(np.linspace(0.1, 300, 12), [0.1, 1, 0.1])  # the last point needs the most substeps
    one = sweep(scene=WITHOUT_METHOD, axes={"body.angular_velocity": spins})
    with client.create({**WITHOUT_METHOD, "members": 12, "body": {"moments": [1, 2, 3], "angular_velocity": spins}}) as session:
        assert methods(one) == [session.scene["method"]] and methods(one)[0]["substeps"] > 1
    monkeypatch.setattr("stiefel._sweep.plan.LARGEST", 5)
    assert sweep(scene=WITHOUT_METHOD, axes={"body.angular_velocity": spins}).attrs["sha256"] == one.attrs["sha256"]


def test_a_tolerance_holds_at_every_point(client):
    """The server chooses one method for all points that share the tolerance."""
    spins = np.geomspace(0.02, 6, 24)[:, np.newaxis] * np.random.default_rng(3).normal(size=(24, 3))
    scene = {"system": "rigid_body", "step": 0.1, "horizon": 0.1 * TO, "body": {"moments": [1, 1.7, 2.2]}}
    axes = {"tolerance": [1e-3, 1e-9], "body.angular_velocity": spins}
    found = sweep(scene=scene, axes=axes, zipped=False)
    assert found["method"].shape == (2, 24) and len({json.dumps(method) for method in methods(found)}) == 2
    exact = sweep(scene={**scene, "method": "exact"}, axes={"body.angular_velocity": spins})
    error = np.abs(found["quaternion.last"].values - exact["quaternion.last"].values).max(axis=(1, 2))
    assert (error <= axes["tolerance"]).all() and error[0] > 1e-9
    with pytest.raises(stiefel.InvalidArgument, match="tolerance") as caught:
        sweep(scene={**scene, "tolerance": 1e-13}, axes={"body.angular_velocity": 3e3 * spins})
    assert caught.value.reason == "TOLERANCE_NOT_MET"


def test_short_sweeps_leave_nothing(tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))  # where servers have their sockets
    this = psutil.Process()

    def held(sweeps):
        for _ in range(sweeps):
            sweep(axes={"body.angular_velocity": SPINS[:3]}, to=3)
        return len(this.children(recursive=True)), this.num_fds(), threading.active_count(), len(list(tmp_path.iterdir()))

    before, memory = held(SWEEPS // 4), this.memory_info().rss
    assert held(SWEEPS) == before and this.memory_info().rss < memory + 20e6 + 2e3 * SWEEPS
