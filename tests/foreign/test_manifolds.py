"""pymanopt and geomstats: their own checks accept the manifolds of stiefel.manifold, and an optimisation ends where it must."""
from __future__ import annotations

import os
import subprocess
from pathlib import Path

import tools


def test_the_checks_of_pymanopt_and_geomstats():
    programs = tools.from_pypi("manifolds")
    script = Path(__file__).with_name("manifolds.py")
    done = subprocess.run([programs / "python", "-W", "ignore", script], capture_output=True, text=True, env=dict(os.environ))
    assert done.returncode == 0, done.stderr
    assert [line.split()[0] for line in done.stdout.splitlines()] == ["pymanopt"] * 5 + ["geomstats"] * 4
