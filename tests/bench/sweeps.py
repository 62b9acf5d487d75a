"""Measures a sweep on two Dask workers of this machine against the same bodies as one ensemble of one server.

    sweeps.py BODIES REPEATS                  (with a Python that has stiefel, distributed, xarray and psutil)
    sweeps.py --environment build/dask        (makes the virtual environment that run.py uses)

Prints a line of JSON for each row of the table: the processor time of the servers, that of all processes, and the time
that passes.
"""
from __future__ import annotations

import json
import os
import subprocess
import sys
import time
import venv
from pathlib import Path
from typing import Any

import numpy as np

PACKAGES = ("distributed>=2022.12", "psutil", "grpcio>=1.51", "protobuf>=4.21,<8", "numpy>=1.21", "xarray>=2022.6")
WORKERS, STEPS, LARGEST = 2, 10_000, 1 << 17  # LARGEST: the most members of an ensemble
SCENE: dict[str, Any] = {"system": "rigid_body", "step": 0.01, "method": {"name": "preprocessed_variational", "order": 10}}
SUMMARIZE = {"quaternion": ["last"], "energy": ["drift"]}


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


class Spent:
    """Seconds of processor time of the servers and of all processes, this one included, and the time that passed."""

    def __enter__(self) -> Spent:
        self._before, self.wall = self._now(), -time.monotonic()
        return self

    def __exit__(self, *exception: object) -> None:
        self.wall += time.monotonic()
        self.servers, self.everything = (after - before for after, before in zip(self._now(), self._before))

    @staticmethod
    def _now() -> list[float]:
        import psutil

        this = psutil.Process()
        seconds = [("stiefel-server" in one.name(), sum(one.cpu_times()[:2])) for one in (this, *this.children(recursive=True))]
        return [sum(of for server, of in seconds if server), sum(of for _, of in seconds)]


def rows(bodies: int, repeats: int) -> list[dict[str, Any]]:
    from distributed import Client, LocalCluster

    import stiefel

    rng = np.random.default_rng(18)
    axes = {"body.moments": 1 + rng.random(size=(bodies, 3)), "body.angular_velocity": rng.normal(size=(bodies, 3))}

    def sweep(count: int, **on: Any) -> Any:
        return stiefel.sweep({**SCENE, "body": {}}, axes={path: values[:count] for path, values in axes.items()}, to=STEPS, zipped=True,
                             summarize=SUMMARIZE, **on)

    pairs = []
    for _ in range(repeats):
        with stiefel.Server.start() as server, stiefel.Client(server.address, timeout=None) as client, Spent() as alone:
            for begin in range(0, bodies, LARGEST):
                part = {path[len("body."):]: values[begin:begin + LARGEST] for path, values in axes.items()}
                with client.create({**SCENE, "members": len(part["moments"]), "body": part}) as session:
                    session.summarize(to=STEPS, quantities=SUMMARIZE)
        with LocalCluster(n_workers=WORKERS, threads_per_worker=1, processes=True, dashboard_address=None) as cluster, \
                Client(cluster) as client:
            sweep(8 * WORKERS, executor=client.get_executor())  # starts the workers' servers
            with Spent() as spread:
                result = sweep(bodies, executor=client.get_executor())
        assert (result["outcome"] == 1).all() and alone.servers > 0, "points are missing, or the servers were not seen"
        pairs.append((spread, alone))
    names = {"servers": "processor time of the servers", "everything": "processor time of all processes", "wall": "time"}
    return [{"name": f"Sweep of {bodies} bodies, {STEPS} steps, {WORKERS} Dask workers: {names[what]}", "unit": "s",
             "ours": [getattr(spread, what) for spread, _ in pairs], "theirs": [getattr(alone, what) for _, alone in pairs],
             "rival": "one ensemble, one server", "bound": bound}
            for what, bound in (("servers", 1.03), ("everything", 1.10), ("wall", None))]


if __name__ == "__main__":
    if sys.argv[1] == "--environment":
        sys.exit(not environment(Path(sys.argv[2]).resolve()))
    for row in rows(int(sys.argv[1]), int(sys.argv[2])):
        print(json.dumps(row), flush=True)
