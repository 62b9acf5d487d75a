"""The page of `stiefel report`, read without a browser."""
from __future__ import annotations

import json
import os
import re
import subprocess

import numpy as np
import pytest

from pages import EXAMPLES, Elements, Page
from stiefel._report import page, run_data

TEMPLATE = page.template()
MOST_OF = {"rigid_body_8": 200, "double_bracket": 100, "moser_veselov": 300, "stiefel": 100, "right_rigid_body": 100}


def test_the_page_loads_nothing():
    names = {name for _, name, _ in Elements(TEMPLATE).attributes}
    assert not names & {"src", "href", "srcset", "data", "action", "onclick"}
    assert not re.search(r"https?:|//[a-z]+\.|url\(|@import|fetch\(|XMLHttpRequest|WebSocket|import\(", TEMPLATE)
    assert "default-src 'none'" in TEMPLATE


def test_the_script_asks_for_elements_that_there_are():
    elements = Elements(TEMPLATE)
    asked = set(re.findall(r'(?:\$\("|querySelector\("#)(\w+)', elements.scripts[1]))
    assert len(asked) > 15 and asked <= set(elements.ids)


@pytest.mark.parametrize("name", MOST_OF)
def test_the_samples_are_those_of_the_run(report, client, name):
    shown = report(name, MOST_OF[name], "--no-estimate-error", "--no-tradeoff")
    time = shown.array("time")
    assert shown.data["to"] == MOST_OF[name] and len(time) > 100 and (np.diff(time) > 0).all()
    with client.create(EXAMPLES / f"{name}.json") as session:
        step, fields = session.scene["step"], run_data.drawn_fields(session)
        if "method" in session.scene:
            states = session.trajectory(times=time, fields=fields)
        else:
            states = session.trajectory(to=MOST_OF[name], fields=fields)
    assert set(shown.data["samples"]["fields"]) == set(fields)
    assert time[0] == 0 and time[-1] == pytest.approx(MOST_OF[name] * step)
    for field in fields:
        assert np.array_equal(shown.array("fields", field), np.asarray(states[field]).astype(
            "c8" if np.iscomplexobj(states[field]) else "f4")), field


def test_drift_and_error_are_those_of_the_diagnosis(report, client):
    shown = report("tumbling_spacecraft", 1200).data
    with client.create(EXAMPLES / "tumbling_spacecraft.json") as session:
        last = session.diagnose(to=1200, estimate_error=True)
    drifts = {family["name"]: family["drift"] for family in shown["drift"]["families"]}
    assert drifts["energy"][-1] == next(one.drift for one in last.invariants if one.name == "energy")
    assert drifts["spatial_momentum"][-1] == max(one.drift for one in last.invariants if one.name.startswith("spatial"))
    assert drifts["orthogonality"][-1] == last.orthogonality and len(drifts["energy"]) == len(shown["drift"]["time"]) == 61
    assert shown["error"]["time"][-1] == 600 and len(shown["error"]["time"]) == 21
    bound = 2 * last.estimated_error.reference_error
    assert shown["error"]["attitude"][-1] == (last.estimated_error.attitude or bound)
    assert [family["count"] for family in shown["drift"]["families"]] == [1, 3, 1, 2, 1]


def test_a_measured_front_is_on_the_page(report):
    tradeoff = report("tumbling_spacecraft", 100).data["tradeoff"]
    front = [point for point in tradeoff["points"] if point["front"]]
    assert len(front) > 1 and len(tradeoff["points"]) > 20 and all(point["error"] > 0 for point in front)
    assert report("moser_veselov", 100).data["tradeoff"] is None


def test_a_long_run_shows_its_first_turns(report):
    shown = report("tumbling_spacecraft", 400_000, "--no-estimate-error", "--no-tradeoff")
    time = shown.array("time")
    assert shown.data["horizon"] == 200_000 and len(time) <= 12_001 and time[-1] < 100_000
    largest = max(np.linalg.norm(attitude) for attitude in np.diff(shown.array("fields", "Q"), axis=0))
    assert largest < 0.25, "the body turns by 0.1 between two samples"
    assert shown.data["drift"]["time"][-1] == 200_000


def test_samples_between_long_steps(report, tmp_path):
    scene = json.loads((EXAMPLES / "tumbling_spacecraft.json").read_text())
    (tmp_path / "slow.json").write_text(json.dumps({**scene, "step": 50}))
    shown = report(tmp_path / "slow.json", 20, "--no-tradeoff")
    assert len(shown.array("time")) > 500 and shown.array("time")[-1] == 1000


def test_a_stopped_run_has_a_page_too(report, tmp_path):
    (tmp_path / "long.json").write_text(json.dumps({
        "system": "rigid_body", "method": {"name": "variational"}, "step": 20,
        "body": {"moments": [1, 2, 3], "angular_velocity": [1, 1, 1]}}))
    shown = report(tmp_path / "long.json", 100, "--no-tradeoff", status=3).data
    assert shown["outcome"] == "LEFT_DOMAIN" and shown["to"] == 0 and "principal branch" in shown["message"]


def test_a_member_of_an_ensemble(report, client, tmp_path):
    scene = {"system": "rigid_body", "members": 3, "step": 0.1, "method": {"name": "variational"},
             "body": {"moments": [1, 2, 2.7], "angular_velocity": [0.3, 1, 0.2, 0.1, 1, 0.1, 1, 0.2, 0.3]}}
    (tmp_path / "three.json").write_text(json.dumps(scene))
    shown = report(tmp_path / "three.json", 200, "--member", "2", "--no-tradeoff", "--no-estimate-error")
    del scene["members"]
    with client.create({**scene, "body": {"moments": [1, 2, 2.7], "angular_velocity": [1, 0.2, 0.3]}}) as session:
        alone = session.trajectory(times=shown.array("time"), fields=["Q"])
    assert shown.data["member"] == 2 and np.array_equal(shown.array("fields", "Q"), alone["Q"].astype("f4"))


def test_a_momentum_only_scene(report, tmp_path):
    (tmp_path / "momentum.json").write_text(json.dumps({
        "system": "rigid_body", "inertia": [1, 2, 3], "step": 0.1,
        "initial": {"M": {"rows": 3, "cols": 3, "values": [0, -1, 2, 1, 0, -3, -2, 3, 0]}}}))
    assert list(report(tmp_path / "momentum.json", 100, "--no-tradeoff").data["samples"]["fields"]) == ["M"]


def test_a_large_frame_is_cut(report, tmp_path):
    n = 120
    rng = np.random.default_rng(1)
    M = rng.normal(size=(n, n))
    scene = {"system": "rigid_body", "inertia": (1 + np.arange(n) / n).tolist(), "step": 0.05, "method": {"name": "rk4"},
             "initial": {"Q": np.eye(n).tolist(), "M": ((M - M.T) / n).tolist()}}
    (tmp_path / "large.json").write_text(json.dumps(scene))
    shown = report(tmp_path / "large.json", 10, "--no-estimate-error", "--no-tradeoff")
    assert shown.array("fields", "Q").shape[1:] == (8, 8)


def test_no_name_ends_the_script(report, tmp_path):
    scene = json.loads((EXAMPLES / "tumbling_spacecraft.json").read_text())
    path = tmp_path / "a<!-- <script>b.json"
    path.write_text(json.dumps(scene))
    shown = report(path, 10, "--no-estimate-error", "--no-tradeoff")
    assert shown.data["name"] == "a<!-- <script>b" and shown.template == TEMPLATE
    text = page.html({"name": "</script><script>alert(1)</script>", "drift": float("nan")})
    block = Elements(text).scripts
    assert len(block) == 2 and json.loads(block[0]) == {"name": "</script><script>alert(1)</script>", "drift": None}


def test_an_example_ends_at_its_horizon(tmp_path):
    """`stiefel report toutatis`, and the words by which the page says how to run it again."""
    def run(*arguments, **more):
        done = subprocess.run([os.environ["STIEFEL_CLI"], "report", *arguments, "--no-tradeoff"], cwd=tmp_path,
                              capture_output=True, text=True, timeout=300, **more)
        return done, Page(tmp_path / "report.html") if done.returncode == 0 else None
    _, page = run("toutatis")
    assert page.data["horizon"] == 2592000 and page.data["name"] == "toutatis" and page.data["file"] == "toutatis.json"
    assert page.data["epoch"] == page.data["scene"]["epoch"] == "1992-11-09T17:49:47 UTC"
    _, page = run("tumbling_spacecraft", "--time", "10.2", "--set", "method.name=rk4")
    assert page.data["to"] == 21 and page.data["scene"]["method"]["name"] == "rk4"
    text = (EXAMPLES / "envisat.json").read_text()
    _, page = run("-", "--to", "5", input=text)
    assert page.data["name"] == "rigid_body" and page.data["file"] == "scene.json"
    done, _ = run("envisat", "--to", "5", "--member", "1")
    assert done.returncode == 2 and "--member: 1: is not a member of the scene" in done.stderr
