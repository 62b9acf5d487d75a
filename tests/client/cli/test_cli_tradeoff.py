"""`stiefel tradeoff`, and scenes that leave the choice of a method to it."""
import csv
import io
import json
import re

import pytest


HEAD = ["method", "order", "arithmetic", "attitude", "momentum", "drift", "work", "CPU", "s/s", "steps/s"]


def is_point(row):
    return "substep" in row or "tolerance" in row


@pytest.fixture
def measured(stiefel, write, scene, tmp_path):
    """What is printed, and the points of its JSON."""
    def measured(*more):
        result = stiefel("tradeoff", write({**scene, "step": 0.1}), "--horizon", 1, "--budget", 2e8, "--repeats", 1,
                         "--output", "points.json", *more)
        assert result.status == 0 and all("ETA" in line or "reference, 0:" in line for line in result.err.splitlines())
        head, table = result.out.split("\n\n", 1)
        assert "closed form" in head and "machine: " in head and re.search("^numerics id: [0-9a-f]{16}$", head, re.M)
        rows = table.splitlines()
        assert rows[0].split() == HEAD
        return rows[1:], json.loads((tmp_path / "points.json").read_text())["points"]
    return measured


def test_tradeoff_prints_its_front(measured):
    rows, points = measured()
    front = sorted((p for p in points if p["front"]), key=lambda p: p["work"])
    shown = [row.removeprefix(" ~").split() for row in rows if is_point(row)]
    assert len(shown) == len(front) < len(points)
    for row, point in zip(shown, front):
        assert row[0] == point["method"]["name"] and f"{point['work']:.2e}" in row
    assert f"The Pareto front, {len(front)} of {len(points)} points" in "\n".join(rows)
    assert "--all" in rows[-2] and not any(row.startswith("*") for row in rows)


def test_tradeoff_prints_all_with_the_front_marked(measured):
    rows, points = measured("--all")
    assert sum(row.startswith("*") for row in rows if is_point(row)) == sum(p["front"] for p in points)
    assert len([row for row in rows if is_point(row)]) == len(points) > 20
    assert [row for row in rows if row.startswith("* the Pareto front")]
    best = min(points, key=lambda p: p["attitude_error"])
    assert best["attitude_error"] < 1e-14 and best["method"].get("scalar", "double") == "double" and best["outcome"] == "REACHED"


def test_tradeoff_writes_csv(stiefel, write, scene, tmp_path):
    path = write({**scene, "step": 0.1})
    assert stiefel("tradeoff", path, "--horizon", 1, "--budget", 2e8, "--repeats", 1, "--output", "p.csv").status == 0
    rows = list(csv.DictReader(io.StringIO((tmp_path / "p.csv").read_text())))
    assert {"rk4", "variational", "adaptive"} <= {row["method"] for row in rows}
    assert any(row["front"] == "1" for row in rows) and float(rows[0]["work"]) > 0
    assert all(float(row["attitude_error"]) > 0 for row in rows)


@pytest.mark.parametrize("arguments, fault", [
    (["--horizon", "-1"], "--horizon"), (["--budget", "0"], "--budget"), (["--repeats", "0"], "--repeats"),
    (["--output", "points.png"], "--output"),
])
def test_tradeoff_refuses(stiefel, write, scene, arguments, fault):
    result = stiefel("tradeoff", write(scene), *arguments)
    assert result.status == 2 and fault in result.err


def test_a_scene_with_a_tolerance_runs(stiefel, write, scene):
    del scene["method"]
    result = stiefel("run", write({**scene, "tolerance": 1e-6, "horizon": 1.0}), "--to", 100, "--every", 100)
    assert result.status == 0 and result.json["outcome"] == "REACHED"
    choice = result.json["choice"]
    assert set(choice) == {"method", "tolerance", "horizon", "reason", "error", "verified"}
    assert choice["method"]["name"] in choice["reason"] and choice["verified"] is True and choice["error"] <= 1e-6
    assert (choice["tolerance"], choice["horizon"]) == (1e-6, 1.0)
    result = stiefel("run", write({**scene, "tolerance": 1e-6}), "--to", 100)
    assert result.status == 2 and "scene.json: horizon: absent" in result.err
