"""Runs any scene and shows its trajectory, a picture, how well its invariants are kept, and the estimated error.

    run_scene.py SCENE.json --steps N [--output FOLDER] [--server ADDRESS]
"""
from __future__ import annotations

import argparse
import sys
import time
from contextlib import nullcontext
from pathlib import Path

import numpy as np

import picture
import stiefel

SAMPLES = 2000
DIAGNOSES = 100


def families(session: stiefel.Session, steps: int) -> tuple[list[float], dict[str, list[float]]]:
    """Returns times, and at each time the largest drift of every family of invariants."""
    times: list[float] = []
    drifts: dict[str, list[float]] = {}
    for step in np.unique(np.linspace(0, steps, DIAGNOSES + 1).astype(int)):
        diagnosis = session.diagnose(to=step)
        largest: dict[str, float] = {}
        for invariant in diagnosis.invariants:
            family = invariant.name.split("[")[0]
            largest[family] = max(largest.get(family, 0.0), invariant.drift)
        if diagnosis.orthogonality is not None:
            largest["orthogonality"] = diagnosis.orthogonality
        times.append(diagnosis.time)
        for family, drift in largest.items():
            drifts.setdefault(family, []).append(drift)
    return times, drifts


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", type=Path)
    parser.add_argument("--steps", type=int, default=10_000)
    parser.add_argument("--output", type=Path, default=Path("build/run"), help="folder for what is written")
    parser.add_argument("--server", help="address of a running server; otherwise one is started")
    arguments = parser.parse_args()
    arguments.output.mkdir(parents=True, exist_ok=True)

    with nullcontext() if arguments.server else stiefel.Server.start() as server, \
            stiefel.Client(arguments.server or server.address) as client, \
            client.create(arguments.scene) as session:
        start = time.perf_counter()
        run = session.trajectory(to=arguments.steps, every=max(arguments.steps // SAMPLES, 1), progress=True)
        seconds = time.perf_counter() - start
        reached = int(run.step[-1])
        times, drifts = families(session, reached)
        last = session.diagnose(to=reached, estimate_error=True)
        scene, choice = session.scene, session.choice

    print(f"{run.outcome} at step {reached}, time {run.time[-1]:.6g}: {run.samples} samples, "
          f"{run.computed_steps / seconds:.2e} steps/s")
    if choice:
        print(f"{scene['method']['name']} was chosen: {choice.reason}")
    if run.run_status.message:
        print(run.run_status.message)
    print("\nlargest drift over the run")
    for family, values in drifts.items():
        print(f"  {family:<20}{max(values):.1e}")
    print(f"estimated error at step {reached}: {last.estimated_error}")
    run.save(arguments.output / "trajectory.npz")
    title = f"{arguments.scene.name}: {scene['system']} {scene.get('method', {}).get('name', '')}"
    picture.scene(arguments.output / "scene.png", title.rstrip(), run, next(iter(run.fields)), times, drifts)
    print(f"\nwrote {arguments.output}/trajectory.npz and {arguments.output}/scene.png")
    return 0 if run.outcome is stiefel.Outcome.REACHED else 3


if __name__ == "__main__":
    try:
        sys.exit(main())
    except (stiefel.StiefelError, OSError) as error:
        print(f"run_scene.py: {error}", file=sys.stderr)
        sys.exit(2)
