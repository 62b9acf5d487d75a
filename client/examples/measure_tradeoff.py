"""Measures what accuracy costs on a scene: draws the work-precision diagram and prints the Pareto front as a table.

    measure_tradeoff.py SCENE.json [--horizon T] [--budget B] [--output FOLDER] [--server ADDRESS]
"""
from __future__ import annotations

import argparse
import sys
from contextlib import nullcontext
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import stiefel


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", type=Path)
    parser.add_argument("--horizon", type=float, help="when errors are measured; the scene's, or 100 steps")
    parser.add_argument("--budget", type=float, help="work in instructions")
    parser.add_argument("--output", type=Path, default=Path("build/run"), help="folder for what is written")
    parser.add_argument("--server", help="address of a running server; otherwise one is started")
    arguments = parser.parse_args()
    arguments.output.mkdir(parents=True, exist_ok=True)

    with nullcontext() if arguments.server else stiefel.Server.start() as server, \
            stiefel.Client(server.address if server else arguments.server, timeout=None) as client:
        tradeoff = client.tradeoff(arguments.scene, horizon=arguments.horizon, budget=arguments.budget)
    points = tradeoff.to_dataframe()
    columns = ["method", "order", "arithmetic", "substeps", "tolerance", "error", "work", "cpu_seconds_per_second"]
    print(f"{len(points)} points at t = {tradeoff.horizon:g} ({tradeoff.steps} steps) against {tradeoff.reference}, its own error "
          f"{tradeoff.reference_error:.0e}\n\n{points[points['front']].sort_values('work')[columns].to_string(index=False)}")
    tradeoff.plot().figure.savefig(arguments.output / "tradeoff.png", dpi=100)
    print(f"\nwrote {arguments.output}/tradeoff.png")
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except (stiefel.StiefelError, OSError) as error:
        print(f"measure_tradeoff.py: {error}", file=sys.stderr)
        sys.exit(2)
