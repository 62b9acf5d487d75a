"""A sweep on two workers of a real cluster of Dask or Ray, with the wheel in an environment of its own: while three
workers are killed, it returns the bytes of a sweep on this machine.

    on_cluster.py dask|ray FOLDER_OF_WHEELS
"""
from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

from environment import environment, wheel_in

PROGRAM = """
import os, sys, threading
import numpy as np, psutil, stiefel

def sweep(**on):
    scene = {"system": "rigid_body", "step": 0.01, "method": {"name": "preprocessed_variational"}, "body": {"moments": [1, 2, 3]}}
    spins = np.random.default_rng(18).normal(size=(40_000, 3))
    return stiefel.sweep(scene, axes={"body.angular_velocity": spins}, to=10_000, summarize={"quaternion": "last"}, **on)

def kill(stop, killed):
    while len(killed) < 3 and not stop.wait(3):
        workers = [one for one in psutil.Process().children(recursive=True) if any("stiefel-server" in child.name() for child in one.children())]
        for one in workers[:1]:
            one.kill()
            killed.append(one.pid)

if __name__ == "__main__":
    if sys.argv[1] == "dask":
        import dask, distributed
        # A worker that is killed again and again is not there 15 s after its death, and the cluster would give its place up.
        dask.config.set({"distributed.deploy.lost-worker-timeout": "1 hour"})
        executor = distributed.Client(n_workers=2, threads_per_worker=1, dashboard_address=None).get_executor()
    else:
        import ray
        os.environ["RAY_AUTH_MODE"] = "disabled"
        ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False)
        executor = stiefel.ray.Executor()
    stop, killed = threading.Event(), []
    threading.Thread(target=kill, args=(stop, killed), daemon=True).start()
    found = sweep(executor=executor)
    stop.set()
    print(len(killed), "workers were killed; failures", found.attrs["failures"])
    assert killed and found.attrs["sha256"] == sweep().attrs["sha256"] and (found["outcome"] == 1).all()
"""


def main(cluster: str, wheels: Path) -> int:
    with tempfile.TemporaryDirectory(prefix="stiefel-cluster.") as name:
        folder = Path(name)
        python = environment(folder / "there", f"{wheel_in(wheels)}[{cluster},xarray]", "psutil")
        (folder / "program.py").write_text(PROGRAM)
        # Ray writes into the home folder.
        return subprocess.run([python, "program.py", cluster], cwd=folder, env={"PATH": "/usr/bin:/bin", "HOME": name}).returncode


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], Path(sys.argv[2])))
