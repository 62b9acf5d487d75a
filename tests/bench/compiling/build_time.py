"""Measures the cost of clean builds of two commits or trees on the same machine, and their ratios: the processor time
(user + sys) of what `make run` and `make test` compile, without ccache.

    /usr/bin/python3 tests/bench/compiling/build_time.py BEFORE [AFTER]     (or: make bench-build BEFORE=commit)

BEFORE and AFTER are commits, or directories with a source tree. Without AFTER, this tree as it stands is measured. A
commit is checked out into its own git worktree, which is removed at the end. --target NAME builds only that target;
--keep leaves the build directories.
"""
from __future__ import annotations

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
# The launcher of the compiler. It appends "seconds object" to a log.
LAUNCHER = """\
import os, resource, subprocess, sys
code = subprocess.run(sys.argv[2:]).returncode
used = resource.getrusage(resource.RUSAGE_CHILDREN)
if "-o" in sys.argv:
    with open(sys.argv[1], "a") as log:
        log.write(f"{used.ru_utime + used.ru_stime:.2f} {sys.argv[sys.argv.index('-o') + 1]}\\n")
sys.exit(code)
"""


@dataclass
class Cost:
    seconds: float  # processor time
    objects: dict[str, float] = field(default_factory=dict)  # processor time of each compilation

    def largest(self, count: int) -> list[tuple[str, float]]:
        return sorted(self.objects.items(), key=lambda item: -item[1])[:count]


def processor_time() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def compile_times(log: str) -> dict[str, float]:
    """Returns the time of each object in a log of "seconds object" lines. Repeated compilations add up."""
    objects: dict[str, float] = {}
    for line in log.splitlines():
        seconds, name = line.split(maxsplit=1)
        objects[name] = objects.get(name, 0) + float(seconds)
    return objects


def run_targets(tree: Path) -> list[str]:
    """Returns the targets that `make run` builds in a tree: all, unless its Makefile has the target build-run."""
    makefile = (tree / "Makefile").read_text()
    return ["stiefel-server", "stiefel_python"] if "\nbuild-run:" in makefile else ["all"]


def build(tree: Path, directory: Path, targets: list[str], jobs: int) -> Cost:
    """Configures a tree in an empty directory and builds the targets there."""
    directory.mkdir(parents=True)
    launcher, log = directory / "launcher.py", directory / "objects.log"
    launcher.write_text(LAUNCHER)
    log.touch()
    start = processor_time()
    quiet = dict(check=True, stdout=subprocess.DEVNULL)
    subprocess.run(["cmake", "-S", str(tree), "-B", str(directory), "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release",
                    f"-DCMAKE_CXX_COMPILER_LAUNCHER={sys.executable};{launcher};{log}"], **quiet)
    subprocess.run(["cmake", "--build", str(directory), "--target", *targets, "-j", str(jobs)],
                   env={**os.environ, "CCACHE_DISABLE": "1"}, **quiet)
    return Cost(processor_time() - start, compile_times(log.read_text()))


def source(what: str, scratch: Path, stack: ExitStack) -> Path:
    """Returns the source tree of a directory or of a commit."""
    if Path(what).is_dir():
        return Path(what).resolve()
    commit = subprocess.run(["git", "-C", str(ROOT), "rev-parse", "--verify", f"{what}^{{commit}}"], check=True,
                            capture_output=True, text=True).stdout.strip()
    tree = scratch / commit
    subprocess.run(["git", "-C", str(ROOT), "worktree", "add", "--quiet", "--detach", str(tree), commit], check=True)
    stack.callback(subprocess.run, ["git", "-C", str(ROOT), "worktree", "remove", "--force", str(tree)], check=True)
    return tree


def report(name: str, before: Cost, after: Cost, bound: float) -> str:
    ratio = after.seconds / before.seconds
    return (f"{name}: {after.seconds:.0f} s of processor time, {before.seconds:.0f} s before: {ratio:.2f} × "
            f"(bound {bound:.2f}, {'kept' if ratio <= bound else 'NOT kept'})")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("before", help="a commit or a directory")
    parser.add_argument("after", nargs="?", default=str(ROOT), help="a commit or a directory; this tree if left out")
    parser.add_argument("--target", action="append", help="build this instead of what `make run` and `make test` build")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--largest", type=int, default=8, help="how many of the dearest objects are listed")
    parser.add_argument("--keep", action="store_true", help="leave the build directories where they are")
    arguments = parser.parse_args()

    with ExitStack() as stack:
        scratch = Path(tempfile.mkdtemp(prefix="build-time."))
        if arguments.keep:
            print(f"build directories: {scratch}")
        else:
            stack.callback(subprocess.run, ["rm", "-rf", str(scratch)], check=True)
        trees = [source(what, scratch, stack) for what in (arguments.before, arguments.after)]
        stages = [("make run", run_targets, 0.25), ("make test", lambda _: ["all", "stiefel_tests"], 0.5)]
        if arguments.target:
            stages = [(" ".join(arguments.target), lambda _: arguments.target, 1.0)]
        found = []
        for name, targets, bound in stages:
            costs = [build(tree, scratch / f"{name.replace(' ', '-')}-{which}", targets(tree), arguments.jobs)
                     for which, tree in zip(("before", "after"), trees)]
            print(report(name, *costs, bound), flush=True)
            found.append({"what": name, "before": costs[0].seconds, "after": costs[1].seconds})
        before, after = costs  # of the last stage, which compiles the most
        dearest = max(before.objects.values(), default=float("nan"))
        for which, cost in (("before", before), ("after", after)):
            print(f"\nthe dearest objects {which}, and their ratio to the dearest before")
            for name, seconds in cost.largest(arguments.largest):
                print(f"  {seconds:7.1f} s  {seconds / dearest:4.2f} ×  {name}")
        print(json.dumps(found))
    return 0


if __name__ == "__main__":
    sys.exit(main())
