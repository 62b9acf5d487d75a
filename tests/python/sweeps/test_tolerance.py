"""Sweeps with a tolerance: it holds at every point, because each has the method that is chosen for it alone."""
import json
import multiprocessing
from concurrent.futures import ProcessPoolExecutor

import numpy as np
import pytest
import zarr
from cases import small_chunks, sweep  # noqa: F401

import stiefel

TOLERANCE, STEP, TO = 1e-6, 0.1, 100
SCENE = {"system": "rigid_body", "step": STEP, "tolerance": TOLERANCE, "horizon": STEP * TO,
         "body": {"moments": [1, 1.7, 2.2], "angular_velocity": [1, 0, 0]}}
RATES = np.geomspace(0.02, 6, 24)
SPINS = RATES[:, np.newaxis] * np.random.default_rng(3).normal(size=(24, 3))
OPTIONS = {"scene": SCENE, "axes": {"body.angular_velocity": SPINS}, "to": TO}


@pytest.fixture(scope="module")
def found():
    return sweep(**OPTIONS)


def methods(result):
    """That of each point."""
    known = json.loads(result.attrs["methods"])
    return [known[which] for which in result["method"].values]


def test_tolerance_and_horizon_are_axes(client):
    tolerances, horizons = [1e-3, 1e-9], [STEP * TO, 2 * STEP * TO]
    without = {name: value for name, value in SCENE.items() if name not in ("tolerance", "horizon")}
    result = sweep(scene=without, axes={"tolerance": tolerances, "horizon": horizons}, to=TO, zipped=False)
    known = json.loads(result.attrs["methods"])
    for i, j in np.ndindex(2, 2):
        with client.create({**without, "tolerance": tolerances[i], "horizon": horizons[j]}) as session:
            assert session.scene["method"] == known[result["method"].values[i, j]]
            assert (session.step(to=TO, fields="quaternion")["quaternion"] == result["quaternion.last"].values[i, j]).all()
    assert len(known) > 1


def test_each_point_has_the_method_and_the_bits_that_it_has_alone(found, client):
    assert len({json.dumps(method) for method in methods(found)}) > 1
    for k in (0, 7, 16, 23):
        scene = {**SCENE, "body": {**SCENE["body"], "angular_velocity": SPINS[k].tolist()}}
        with client.create(scene) as session:
            assert session.scene["method"] == methods(found)[k]
            assert (session.step(to=TO, fields="quaternion")["quaternion"] == found["quaternion.last"].values[k]).all()


def test_the_tolerance_holds_at_every_point(found):
    """It would not with the method of the first point, the slowest."""
    exact = {name: value for name, value in SCENE.items() if name not in ("tolerance", "horizon")}

    def errors(method):
        other = sweep(**{**OPTIONS, "scene": {**exact, "method": method}})
        return np.abs(found["quaternion.last"] - other["quaternion.last"]).values.max(axis=1)

    assert (errors({"name": "exact", "arithmetic": "compensated"}) <= TOLERANCE).all()
    assert errors(methods(found)[0]).max() > TOLERANCE


@pytest.mark.usefixtures("small_chunks")
def test_the_bytes_do_not_depend_on_who_chooses(found, tmp_path):
    assert sweep(**OPTIONS).attrs["sha256"] == found.attrs["sha256"]
    with ProcessPoolExecutor(2, mp_context=multiprocessing.get_context("spawn")) as pool:
        spread = sweep(**OPTIONS, executor=pool, threads=1, store=tmp_path / "sweep.zarr")
    assert spread.equals(found)
    zarr.open_group(str(tmp_path / "sweep.zarr"))["done"][1] = 0
    assert sweep(**OPTIONS, store=tmp_path / "sweep.zarr").equals(found)


def test_the_attributes_make_the_sweep_again(found):
    scene = json.loads(found.attrs["scene"])
    assert scene["tolerance"] == TOLERANCE and "method" not in scene
    assert sweep(**{**OPTIONS, "scene": scene}).attrs["sha256"] == found.attrs["sha256"]


def test_with_other_axes(found):
    """Points whose ensembles differ choose apart, in a grid too."""
    axes = {"step": [STEP, STEP / 2], "body.angular_velocity": SPINS[::8]}
    grid = sweep(**{**OPTIONS, "axes": axes, "zipped": False})
    assert grid["method"].shape == (2, 3)
    assert (grid["quaternion.last"].values[0] == found["quaternion.last"].values[::8]).all()


def test_a_point_where_no_method_meets_it_is_named():
    """Rounding alone turns the fast body by more."""
    spins = np.tile([1, 0.2, 0.1], (24, 1))
    spins[17] *= 3e3
    with pytest.raises(stiefel.InvalidArgument, match=r"tolerance.*\(at point 17\)") as caught:
        sweep(scene={**SCENE, "tolerance": 1e-13}, axes={"body.angular_velocity": spins}, to=TO)
    assert caught.value.reason == "TOLERANCE_NOT_MET"


def test_the_recommended_method_of_each_step_is_recorded(client):
    """Substeps follow the step: they are of one size at most."""
    M = np.diag([1.0, 2, 3], 1) - np.diag([1.0, 2, 3], -1)
    scene = {"system": "rigid_body", "step": 0.01, "inertia": [1, 2, 3, 4], "initial": {"Q": np.eye(4), "M": M}}
    steps = [0.1, 1.0, 3.0]
    result = sweep(scene=scene, axes={"step": steps}, to=3, summarize={"energy": "last"})
    alone = []
    for step in steps:
        with client.create({**scene, "step": step}) as session:
            alone.append(session.scene["method"])
    assert methods(result) == alone and len({method["substeps"] for method in alone}) == 3
    named = sweep(scene={**scene, "method": {"name": "rk4"}}, axes={"step": steps}, to=3, summarize={"energy": "last"})
    assert "method" not in named and json.loads(named.attrs["scene"])["method"]["name"] == "rk4"
