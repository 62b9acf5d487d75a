"""`stiefel poincare`."""
import json

import numpy as np
import pytest

SCENE = {"system": "ellipsoid", "inertia": [1, 4, 9], "step": 0.05, "method": {"name": "variational", "order": 8},
         "initial": {"q": {"rows": 1, "cols": 3, "values": [0.6, 0.8, 0]}, "qdot": {"rows": 1, "cols": 3, "values": [-0.4, 0.3, 0.5]}}}
COORDINATES = [f"{field}={','.join('1' if i == k else '0' for i in range(3))}" for field in ("q", "qdot") for k in range(3)]


def test_joachimsthal_s_integral_is_constant_at_the_crossings(stiefel, write):
    result = stiefel("poincare", write(SCENE), "--to", 10_000, "--section", "q=0,0,1",
                     *(word for text in COORDINATES for word in ("--coordinate", text)))
    assert result.status == 0, result.err
    crossings = result.json["crossings"]
    points = np.array([crossing["point"] for crossing in crossings])
    q, v = points[:, :3], points[:, 3:]
    kept = (q**2 @ [1, 1 / 4, 1 / 9]) * (v**2).sum(axis=1)
    assert result.json["outcome"] == "REACHED" and len(points) > 30 and np.ptp(kept) < 1e-10 * kept[0] and (v[:, 2] > 0).all()
    for crossing in crossings:
        assert crossing["residual"] == crossing["point"][2] and abs(crossing["residual"]) < 1e-15
        assert crossing["time"] == pytest.approx((crossing["step"] + crossing["fraction"]) * 0.05, rel=1e-15)


def test_level_direction_start_and_a_file(stiefel, write, tmp_path):
    path, plane = write(SCENE), ("--section", "q=0,0,1", "--level", "0.1")
    both = stiefel("poincare", path, "--to", 2000, *plane, "--direction", "both").json["crossings"]
    ways = [stiefel("poincare", path, "--to", 2000, *plane, "--direction", way).json["crossings"] for way in ("rising", "falling")]
    assert sorted(crossing["time"] for way in ways for crossing in way) == [crossing["time"] for crossing in both] and all(ways)
    result = stiefel("poincare", path, "--from", 1000, "--to", 2000, *plane, "--direction", "both", "--output", tmp_path / "out.json")
    assert result.status == 0 and result.out == ""
    assert json.loads((tmp_path / "out.json").read_text())["crossings"] == [one for one in both if one["step"] >= 1000]


def test_the_terms_of_a_plane_are_added(stiefel, write):
    """On qdot_3 = q_1, as the coordinates of the crossings say."""
    crossings = stiefel("poincare", write(SCENE), "--to", 4000, "--section", "qdot=0,0,1", "--section", "q=-1,0,0",
                        "--coordinate", "q=1,0,0", "--coordinate", "qdot=0,0,1", "--direction", "both").json["crossings"]
    points = np.array([crossing["point"] for crossing in crossings])
    assert len(points) > 30 and np.ptp(points[:, 0]) > 0.1 and abs(points[:, 0] - points[:, 1]).max() < 1e-14
    assert [one["residual"] for one in crossings] == list(points[:, 1] - points[:, 0])


def test_the_members_of_an_ensemble_are_told_apart(stiefel, write):
    two = {**SCENE, "members": 2, "initial": {name: {"rows": 2, "cols": 3, "values": block["values"] + [2 * x if name == "qdot" else x for x in block["values"]]}
                                              for name, block in SCENE["initial"].items()}}
    crossings = stiefel("poincare", write(two), "--to", 1000, "--section", "q=0,0,1").json["crossings"]
    alone = stiefel("poincare", write(SCENE, "alone.json"), "--to", 1000, "--section", "q=0,0,1").json["crossings"]
    assert {one["member"] for one in crossings} == {0, 1}
    assert [one["time"] for one in crossings if one["member"] == 0] == [one["time"] for one in alone]


@pytest.mark.parametrize("arguments, message", [
    ([], "--section is required"), (["--section", "q"], "--section: q: must be FIELD=NUMBER"),
    (["--section", "q=0,x,1"], "x is no number"), (["--section", "q=0,,1"], "is no number"), (["--section", "q=0,1"], "must be 3"),
    (["--section", "z=0,0,1"], "must be one of"), (["--section", "q=0,0,0"], "must not all be 0"),
    (["--section", "q=0,0,1", "--direction", "up"], "up"), (["--section", "q=0,0,1", "--coordinate", "qdot=1,0"], "must have as many coefficients"),
])
def test_bad_input_is_told(stiefel, write, arguments, message):
    result = stiefel("poincare", write(SCENE), "--to", 400, *arguments)
    assert result.status == 2 and message in result.err and result.out == ""
