"""Runs all measurements, most of them against a rival in the same run, and writes the results.

    /usr/bin/python3 tests/bench/run.py build/release     (or: make bench)

Prints one table and writes it to bench/ beside the build directory: bench.md, bench.json, bench.png, and the picture
work_precision.png. With --peers (make bench-peers) it makes only the comparisons with other packages and writes
peers.md and so on.
"""
from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

# This must precede the import of grpc.
sys.dont_write_bytecode = True

import callgrind
import prices
import report
import sweeps
import weights
from measured_servers import Process, bare_echo, stiefel_server, what_closes
from peers import contest, environment

COUNTS = dict(repeats=9, calls=2000, shorts=1000, samples=1_000_000, seconds=0.05, largest=256, columns=4_000_000,
              members=65536, unread=100, idle=1000, pairs=64, instructions=2000, bodies=100_000, sweeps=2, geodesics=7)
# Small counts that only show that everything runs.
SMOKE = dict(repeats=1, calls=20, shorts=20, samples=5000, seconds=0.001, largest=8, columns=100_000, members=2048,
             unread=5, idle=20, pairs=2,
             instructions=0, bodies=0, sweeps=0, geodesics=0)
THREADS = 2


def measure(build: Path, counts: dict[str, float]) -> list[dict]:
    programs = build / "tests/bench"
    found: list[dict] = []

    def run(program: str, *arguments: object) -> None:
        print(f"  {program} {' '.join(map(str, arguments))}", file=sys.stderr)
        command = program if program.endswith(".py") else programs / f"bench_{program}"
        interpreter = [sys.executable] if program.endswith(".py") else []
        output = subprocess.run([*interpreter, str(command), *map(str, arguments)], check=True,
                                stdout=subprocess.PIPE, text=True).stdout
        found.extend(json.loads(line) for line in output.splitlines())

    def serve(*arguments: object) -> Process:
        return stiefel_server(build, *arguments)

    repeats = counts["repeats"]
    with serve() as server, bare_echo(programs) as echo:
        run("latency", server.address, echo.address, repeats, counts["calls"])
    with tempfile.TemporaryDirectory() as folder:
        arguments, authority, token = what_closes(build, Path(folder))
        with serve() as server, serve(*arguments) as closed:
            run("closed", server.address, closed.address, authority, token, repeats, counts["calls"])
    with serve() as server, bare_echo(programs) as echo:
        run("streaming", server.address, echo.address, repeats, counts["samples"])
        os.environ["PYTHONPATH"] = os.pathsep.join([str(build / "python"), str(programs)])
        run(str(Path(__file__).parent / "streaming.py"), server.address, echo.address, repeats, counts["samples"])
    run("steps", repeats, counts["seconds"], counts["largest"])
    run("large", repeats, counts["largest"], counts["seconds"])
    run("large", "cores", repeats, counts["largest"], min(counts["columns"], 1_000_000), 10 * counts["seconds"])
    run("cores", min(repeats, 3), min(counts["members"], 48_000), 4 * counts["largest"], min(counts["columns"], 1_000_000))
    largest, columns = counts["largest"], min(counts["columns"], 200_000)
    for size in ((largest, 0.05), (largest, 0.2), (2 * largest, 0.2), ("frames", columns)):
        run("divided", *size, 20, 2, 4, 8, 16)
    run("ensembles", repeats, counts["seconds"])
    run("exact", repeats, counts["seconds"])
    run("summaries", repeats, counts["seconds"])
    run("frames", repeats, counts["columns"])
    run("frames", "memory", min(counts["columns"], 1_000_000))
    with serve("--threads", THREADS) as server:
        run("workers", server.address, server.pid, THREADS, repeats)
    with serve("--threads", 2) as two, serve("--threads", 1) as one:
        run(str(Path(__file__).parent / "service/large_ensembles.py"), two.address, two.pid, one.address, one.pid, repeats,
            counts["members"], 1000 * counts["members"])
    for threads in (k for k in (1, 2, 4, 8) if k <= (os.cpu_count() or 1)):
        with serve("--threads", threads) as server:
            run(str(Path(__file__).parent / "service/clients.py"), server.address, threads, min(repeats, 3), 20 * counts["seconds"])
    with serve("--threads", 2) as two, serve("--threads", 1) as one, serve("--threads", 1) as other:
        run("pairs", two.address, one.address, other.address, repeats, counts["pairs"])
    with Process([str(programs / "bench_overload"), "serve", str(THREADS)]) as server:
        run("overload", server.address, THREADS, repeats, counts["shorts"])
    # Each measurement has its own server, because it reads the peak of the server's memory.
    for N, sessions in ((3, counts["unread"]), (64, 1)):
        with serve() as server:
            run("crowd", server.address, server.pid, "unread", counts["unread"], N, sessions)
    with serve() as server:
        run("crowd", server.address, server.pid, "idle", counts["idle"])
    if counts["geodesics"]:
        found += geodesics(build, counts["geodesics"])
        found += sensitivities(build, counts["geodesics"])
    found += callgrind.measure(programs / "bench_instructions", counts["instructions"])
    found += callgrind.tangents(programs / "bench_tangents", counts["instructions"] // 40)
    if counts["instructions"]:
        found += callgrind.undivided(programs / "bench_divided", counts["largest"], min(counts["columns"], 100_000))
    if counts["instructions"]:
        found += weights.measure(programs / "bench_weights")
        found += prices.measure(programs / "bench_prices")
    if counts["bodies"]:
        print(f"  sweeps.py {counts['bodies']} {counts['sweeps']}", file=sys.stderr)
        found += sweeps.measure(build, counts["bodies"], counts["sweeps"])
    return found


def geodesics(build: Path, repeats: int) -> list[dict]:
    """The rows of geodesics.py, whose rivals need SciPy: that of the peers' environment, or Debian's."""
    peers = environment.python_of(build.parent / "peers")
    python = peers if peers.exists() else sys.executable
    if subprocess.run([python, "-c", "import scipy"], stderr=subprocess.DEVNULL).returncode:
        print("  geodesics.py is left out: no SciPy", file=sys.stderr)
        return []
    done = subprocess.run([python, Path(__file__).parent / "peers/geodesics.py", build / "tests/bench/bench_geodesics", str(repeats)],
                          check=True, stdout=subprocess.PIPE, text=True,
                          env={**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "PYTHONPATH": str(build / "python"),
                               "STIEFEL_SERVER": str(build / "bin/stiefel-server")})
    return [json.loads(line) for line in done.stdout.splitlines()]


def sensitivities(build: Path, repeats: int) -> list[dict]:
    """The rows of sensitivities.py, whose rival is heyoka."""
    python = environment.python_of(build.parent / "peers")
    if not python.exists() or subprocess.run([python, "-c", "import heyoka"], stderr=subprocess.DEVNULL).returncode:
        print("  sensitivities.py is left out: no heyoka", file=sys.stderr)
        return []
    done = subprocess.run([python, Path(__file__).parent / "peers/sensitivities.py", build / "tests/bench/bench_sensitivities",
                           str(repeats)], check=True, stdout=subprocess.PIPE, text=True)
    return [json.loads(line) for line in done.stdout.splitlines()]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("build", type=Path, help="the build directory")
    parser.add_argument("--smoke", action="store_true", help="small counts, nothing is written")
    parser.add_argument("--peers", action="store_true", help="only beside other packages")
    arguments = parser.parse_args()
    build = arguments.build.resolve()
    found = [] if arguments.peers else measure(build, SMOKE if arguments.smoke else COUNTS)
    if found and not arguments.smoke:
        # The contest takes several minutes more. A run that is stopped there has its table.
        report.write(found, build, "bench", contest={}, appendix="")
    # The smoke test needs no packages.
    python = environment.python_of(build.parent / "peers")
    rows, curves = contest.measure(build / "tests/bench/bench_contestants",
                                   python if python.exists() and not arguments.smoke else None,
                                   contest.SMOKE if arguments.smoke else contest.FULL)
    found += rows
    if arguments.smoke:
        print(report.table([report.Row.of(entry) for entry in found]))
        return
    name = "peers" if arguments.peers else "bench"
    folder = report.write(found, build, name, contest=curves, appendix=contest.table(curves))
    report.tell(found, folder, name)
    sys.path.insert(0, str(build / "python"))
    from peers import picture  # imported here because it takes the styles of curves from the package of this build

    picture.draw(curves, report.circumstances(build), folder / "work_precision.png")


if __name__ == "__main__":
    main()
