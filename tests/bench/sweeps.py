"""Measures a sweep on two Dask workers of this machine against the same bodies as one ensemble of one server.

    sweeps.py BODIES REPEATS                  (with a Python that has stiefel, distributed and psutil)
    sweeps.py --environment build/dask        (makes the virtual environment that run.py uses)

Prints a line of JSON for each row of the table: the processor time of the servers, that of all processes, and the time
that passes.
"""
from __future__ import annotations

import json
import os
import subprocess
import sys
import venv
from pathlib import Path
from typing import Any

PACKAGES = ("distributed>=2022.12", "psutil", "grpcio>=1.51", "protobuf>=4.21,<8", "numpy>=1.21", "xarray>=2022.6")
CLUSTER = Path(__file__).resolve().parents[1] / "cluster"  # whose soak test has the bodies and counts processor time
WORKERS = 2


def environment(folder: Path) -> bool:
    """Installs what the measurement needs. Returns False where pip cannot, for example without PyPI."""
    python = folder / "bin/python"
    if not python.exists():
        venv.create(folder, with_pip=True)
    pip = [str(python), "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--no-input", "--only-binary=:all:"]
    return subprocess.run([*pip, *PACKAGES], stdout=subprocess.DEVNULL).returncode == 0


def measure(build: Path, bodies: int, repeats: int) -> list[dict[str, Any]]:
    """Returns the rows, measured by another process; none where the environment cannot be made."""
    folder = build.parent / "dask"
    if not environment(folder):
        print("  no sweep on Dask: pip cannot install distributed", file=sys.stderr)
        return []
    settings = {**os.environ, "PYTHONPATH": str(build / "python"), "STIEFEL_SERVER": str(build / "bin/stiefel-server")}
    output = subprocess.run([folder / "bin/python", __file__, str(bodies), str(repeats)], check=True, env=settings,
                            stdout=subprocess.PIPE, text=True).stdout
    return [json.loads(line) for line in output.splitlines() if line.startswith("{")]


def rows(bodies: int, repeats: int) -> list[dict[str, Any]]:
    sys.path.insert(0, str(CLUSTER))
    import soak

    pairs = []
    for _ in range(repeats):
        alone = soak.one_ensemble(bodies)
        spread, result = soak.on_workers(bodies, soak.dask, WORKERS)
        assert soak.missing(result) == 0 and alone.servers > 0, "points are missing, or the servers were not seen"
        pairs.append((spread, alone))
    bounds = {"servers": soak.SERVERS_BOUND, "everything": soak.EVERYTHING_BOUND["dask"], "wall": None}
    names = {"servers": "processor time of the servers", "everything": "processor time of all processes", "wall": "time"}
    return [{"name": f"Sweep of {bodies} bodies, {soak.STEPS} steps, {WORKERS} Dask workers: {names[what]}", "unit": "s",
             "ours": [getattr(spread, what) for spread, _ in pairs], "theirs": [getattr(alone, what) for _, alone in pairs],
             "rival": "one ensemble, one server", "bound": bound} for what, bound in bounds.items()]


if __name__ == "__main__":
    if sys.argv[1] == "--environment":
        sys.exit(not environment(Path(sys.argv[2]).resolve()))
    for row in rows(int(sys.argv[1]), int(sys.argv[2])):
        print(json.dumps(row), flush=True)
