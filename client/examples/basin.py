"""Counts how often a tumbling body turns over, for each initial spin on a plane: one body per pixel.

    basin.py [--pixels N] [--on WHERE] [--store FOLDER] [--output FOLDER]

The moments are 1, 2, 3 kg m² and the spin about the middle axis begins at 1 rad/s; the spins about the other two are the
axes of the picture. The body turns over when the spin about its middle axis changes sign. N is 320 by default, which
makes 102 400 bodies, about a minute on two cores. WHERE tells what computes them:

    cores              this machine, the default
    dask:ADDRESS       a Dask cluster by its scheduler: dask:tcp://10.0.0.1:8786
    ray:ADDRESS        a Ray cluster: ray:auto
    mpi                the processes of mpiexec: mpiexec -n 64 python3 -m mpi4py.futures basin.py --on mpi
    HOST:PORT,...      running servers

With --store the sweep can be interrupted at any time; the same command resumes it. Writes basin.png.
"""
from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

import picture
import stiefel

MOMENTS = (1.0, 2.0, 3.0)
LARGEST = 2.0  # rad/s, at the edge of the picture
STEP, STEPS = 0.05, 2000  # 100 s
SCENE: stiefel.Scene = {"system": "rigid_body", "step": STEP, "method": {"name": "preprocessed_variational"},
         "body": {"moments": MOMENTS, "angular_velocity": [0.0, 1.0, 0.0]}}


def workers(where: str) -> dict[str, Any]:
    """Returns the argument of `stiefel.sweep` that names the workers."""
    kind, _, address = where.partition(":")
    if kind == "cores":
        return {}
    if kind == "dask":
        from distributed import Client

        return {"executor": Client(address).get_executor()}
    if kind == "ray":
        return {"executor": stiefel.ray.Executor(address=address or None)}
    if kind == "mpi":
        from mpi4py.futures import MPIPoolExecutor

        return {"executor": MPIPoolExecutor()}
    return {"servers": where.split(",")}


def flips(pixels: int, on: dict[str, Any], store: "Path | None" = None, progress: bool = False) -> Any:
    """Runs the sweep over a plane of `pixels` x `pixels` spins, none of which is 0."""
    spins = LARGEST * (2 * np.arange(pixels) + 1 - pixels) / pixels
    return stiefel.sweep(SCENE, axes={"body.angular_velocity[2]": spins, "body.angular_velocity[0]": spins}, to=STEPS,
                         summarize={"angular_velocity": ["sign_changes"], "energy": ["drift"]},
                         store=store, progress=progress, **on)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pixels", type=int, default=320, help="of one side of the picture")
    parser.add_argument("--on", default="cores", help="who computes")
    parser.add_argument("--store", type=Path, help="folder that keeps what is computed")
    parser.add_argument("--output", type=Path, default=Path("build/run"), help="folder for the picture")
    arguments = parser.parse_args()
    arguments.output.mkdir(parents=True, exist_ok=True)

    begun = time.perf_counter()
    result = flips(arguments.pixels, workers(arguments.on), arguments.store, progress=sys.stderr.isatty())
    seconds = time.perf_counter() - begun
    count = np.asarray(result["angular_velocity.sign_changes"])[:, :, 1]
    print(f"{count.size} bodies, {STEPS} steps each, in {seconds:.1f} s: {count.size * STEPS / seconds:.1e} steps/s")
    print(f"they turned over {count.min()} to {count.max()} times; energy drifted by at most "
          f"{np.asarray(result['energy.drift']).max():.0e}")
    print(f"SHA-256 of the result: {result.attrs['sha256']}")
    picture.basin(arguments.output / "basin.png", count, LARGEST, MOMENTS, STEP * STEPS)
    print(f"wrote {arguments.output}/basin.png")


if __name__ == "__main__":
    main()
