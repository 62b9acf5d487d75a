"""`stiefel tradeoff`, and scenes that leave the choice of a method to it."""
import csv
import io
import json

import pytest


def test_tradeoff_prints_a_table_with_its_front(stiefel, write, scene, tmp_path):
    result = stiefel("tradeoff", write({**scene, "step": 0.1}), "--horizon", 1, "--budget", 2e8, "--repeats", 1,
                     "--output", "points.json")
    assert result.status == 0 and result.err == ""
    head, table = result.out.split("\n\n", 1)
    assert "closed form" in head and "machine: " in head and "build: stiefel" in head
    rows = table.splitlines()
    assert rows[0].split() == ["method", "order", "arithmetic", "attitude", "momentum", "drift", "work", "CPU", "s/s",
                               "steps/s"]
    points = json.loads((tmp_path / "points.json").read_text())["points"]
    assert sum(row.startswith("*") for row in rows if row.split()[1:2] != ["no"]) == sum(p["front"] for p in points)
    assert len([row for row in rows if "substep" in row or "tolerance" in row]) == len(points) > 20
    best = min(points, key=lambda p: p["attitude_error"])
    assert best["attitude_error"] < 1e-14 and best["scalar"] == "double" and best["outcome"] == "REACHED"


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
    result = stiefel("run", write({**scene, "tolerance": 1e-6}), "--to", 100)
    assert result.status == 2 and "scene.json: horizon: absent" in result.err
