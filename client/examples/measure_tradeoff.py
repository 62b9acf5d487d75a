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


def table(tradeoff: stiefel.Tradeoff) -> str:
    lines = ["| method | error | work | CPU seconds a simulated second |", "| --- | --- | --- | --- |"]
    for point in tradeoff.front:
        knob = f"tolerance {point.tolerance:.0e}" if point.tolerance else f"substeps {point.substeps}"
        about = "~" if point.extrapolated else ""
        times = sorted(point.cpu_seconds_per_second)
        entry = f"`{point.method}`" + (f" {point.order}" if point.order else "")
        scalar = ", float" if point.scalar == "float" else ""
        lines.append(f"| {entry}, {point.arithmetic}{scalar}, {knob} | {about}{point.error:.1e} | "
                     f"{about}{point.work:.1e} | {times[len(times) // 2]:.1e} |")
    return "\n".join(lines)


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
    setup = tradeoff.setup
    print(f"{len(tradeoff.points)} points at t = {setup.horizon:g} ({setup.steps} steps) against {setup.reference}, "
          f"its own error {setup.reference_error:.0e}\n\n{table(tradeoff)}")
    tradeoff.plot().figure.savefig(arguments.output / "tradeoff.png", dpi=100)
    print(f"\nwrote {arguments.output}/tradeoff.png")
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except (stiefel.StiefelError, OSError) as error:
        print(f"measure_tradeoff.py: {error}", file=sys.stderr)
        sys.exit(2)
