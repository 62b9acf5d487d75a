"""Measures the processor time (user + sys) after which the command runs again when one file has changed: a new method,
or a line of a system. The bound is 60 s.

    /usr/bin/python3 tests/bench/compiling/rebuild_time.py build/release [SYSTEM ...]

SYSTEM is the name of a header with the equations of a system; without any, all of them are measured. The build must be
up to date. The headers are touched; the method is the one of tests/support/toys, which is taken out again at the end.
"""
from __future__ import annotations

import os
import re
import resource
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[3]
METHODS = ROOT / "engine/methods"
BOUND = 60.0  # seconds
# The headers with the equations of the continuous systems, by name.
SYSTEMS = {path.stem: path for path in sorted((ROOT / "engine").rglob("*.h"))
           if re.search(r"^  static constexpr const char\* name = ", path.read_text(), re.M)}


class Cost(NamedTuple):
    seconds: float  # processor time
    objects: int


def rebuild(build: Path) -> Cost:
    """Builds the command and says what that took. Links and the configuration count too."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(["cmake", "--build", str(build), "--target", "stiefel"], text=True, check=True,
                          stdout=subprocess.PIPE, env={**os.environ, "CCACHE_DISABLE": "1"})
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return Cost(seconds, done.stdout.count("Building CXX object"))


def report(what: str, cost: Cost) -> None:
    verdict = "kept" if cost.seconds <= BOUND else "NOT kept"
    print(f"{what:36} {cost.objects:3} objects {cost.seconds:7.1f} s of processor time (bound {BOUND:.0f}, {verdict})",
          flush=True)


def after_a_new_method(build: Path) -> Cost:
    """The cost of one file and one line."""
    listing, header = METHODS / "methods.inc", METHODS / "heun.h"
    lines = listing.read_text()
    toy = (ROOT / "tests/support/toys/heun.h").read_text()
    try:
        header.write_text(toy.replace("tests/support/toys/heun.h", "engine/methods/heun.h"))
        listing.write_text(lines + "METHOD(heun, Heun)\n")
        return rebuild(build)
    finally:
        header.unlink()
        listing.write_text(lines)
        rebuild(build)


def main() -> int:
    build = Path(sys.argv[1])
    systems = sys.argv[2:] or sorted(SYSTEMS)
    rebuild(build)
    report("a new method", after_a_new_method(build))
    for system in systems:
        SYSTEMS[system].touch()
        report(f"a line of {SYSTEMS[system].relative_to(ROOT)}", rebuild(build))
    return 0


if __name__ == "__main__":
    sys.exit(main())
