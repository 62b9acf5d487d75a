"""Runs any scene, prints drift and estimated error, and draws rates, spin axis and polhode over the first turns.

    run_scene.py SCENE.json --steps N [--output FOLDER] [--server ADDRESS]
"""
from __future__ import annotations

import argparse
import sys
import time
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import numpy as np

import picture
import stiefel

SAMPLES = 2000
TURNS = 10  # that are drawn


def first_turns(session: stiefel.Session, last_step: int) -> stiefel.Trajectory:
    """Returns samples of the first turns, between the steps too where the system has states there."""
    scene: dict[str, Any] = {**session.scene}
    step = scene["step"]
    speed = session.diagnose(to=0).domain.h_omega * scene.get("method", {}).get("substeps", 1) / abs(step)
    end = min(last_step * abs(step), 2 * np.pi * TURNS / speed if speed else np.inf)
    if last_step == 0 or "method" not in scene:  # a discrete system
        return session.trajectory(to=min(last_step, int(np.ceil(end / abs(step)))))
    return session.trajectory(times=np.linspace(0, np.copysign(end, step), SAMPLES + 1))


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", type=Path)
    parser.add_argument("--steps", type=int, default=10_000)
    parser.add_argument("--output", type=Path, default=Path("build/run"), help="folder for what is written")
    parser.add_argument("--server", help="address of a running server; otherwise one is started")
    arguments = parser.parse_args()
    arguments.output.mkdir(parents=True, exist_ok=True)

    with nullcontext() if arguments.server else stiefel.Server.start() as server, \
            stiefel.Client(server.address if server else arguments.server) as client, \
            client.create(arguments.scene) as session:
        start = time.perf_counter()
        run = session.trajectory(to=arguments.steps, every=max(arguments.steps // SAMPLES, 1), progress=True)
        seconds = time.perf_counter() - start
        reached = int(run.step[-1])
        print(f"{run.outcome} at step {reached}, time {run.time[-1]:.6g}: {run.samples} samples, "
              f"{run.computed_steps / seconds:.2e} steps/s")
        if session.choice:
            print(f"{session.choice.method['name']} was chosen: {session.choice.reason}")
        if run.run_status.message:
            print(run.run_status.message)
        last = session.diagnose(to=reached, estimate_error=True)
        largest: dict[str, float] = {}
        for invariant in last.invariants:
            family = invariant.name.split("[")[0]
            largest[family] = max(largest.get(family, 0.0), invariant.drift)
        print(f"\nlargest drift at step {reached}")
        for family, drift in largest.items():
            print(f"  {family:<20}{drift:.1e}")
        print(f"estimated error at step {reached}: {last.estimated_error}")
        run.save(arguments.output / "trajectory.npz")
        method: Any = run.scene.get("method", {})
        title = f"{arguments.scene.name}: {run.scene.get('system')} {method.get('name', '')}"
        picture.scene(arguments.output / "scene.png", title.rstrip(), first_turns(session, reached), reached)
    print(f"\nwrote {arguments.output}/trajectory.npz and {arguments.output}/scene.png")
    return 0 if run.outcome is stiefel.Outcome.REACHED else 3


if __name__ == "__main__":
    try:
        sys.exit(main())
    except (stiefel.StiefelError, OSError) as error:
        print(f"run_scene.py: {error}", file=sys.stderr)
        sys.exit(2)
