#!/usr/bin/env python3
"""Runs a build by ninja and shows how far it is.

Usage: docker/build.py PRESET JOBS TARGET...

On a terminal ninja rewrites its own status line. Without one this prints every ten seconds

    building: 37 of 106, about 4 min left

and what ninja prints beside its status: warnings, and the output of what failed.
"""
from __future__ import annotations

import os
import queue
import re
import subprocess
import sys
import threading
import time
from typing import IO, Callable, Iterable, Iterator

STATUS = re.compile(r"\[(\d+)/(\d+)\] ")  # NINJA_STATUS below
INTERVAL = 10.0  # seconds


def left(finished: int, total: int, elapsed: float) -> str:
    """The time left in words, from the mean time of what is finished; "" while fewer than 5 are."""
    if finished < 5:
        return ""
    seconds = elapsed / finished * (total - finished)
    return f", about {seconds / 60:.0f} min left" if seconds >= 90 else f", about {seconds:.0f} s left"


def lines(stream: IO[str], wait: float) -> Iterator[str | None]:
    """The lines of a stream as they come; None whenever none came for `wait` seconds."""
    come: queue.Queue[str] = queue.Queue()

    def read() -> None:
        for line in stream:
            come.put(line)
        come.put("")

    threading.Thread(target=read, daemon=True).start()
    while True:
        try:
            line = come.get(timeout=wait)
        except queue.Empty:
            yield None
            continue
        if not line:
            return
        yield line


def follow(output: Iterable[str | None], show: Callable[[str], None], interval: float = INTERVAL,
           clock: Callable[[], float] = time.monotonic) -> None:
    """Shows the progress that ninja's output tells, a line each `interval` seconds, and all else in it.

    `output` has ninja's lines, and None where there was none for a while.
    """
    start = shown = clock()
    finished = total = 0
    for line in output:
        status = STATUS.match(line) if line else None
        if status:
            finished, total = int(status[1]), int(status[2])
        elif line and not line.startswith("ninja: no work to do"):
            show(line.rstrip("\n"))
        now = clock()
        if now - shown >= interval and total > 0:
            show(f"building: {finished} of {total}{left(finished, total, now - start)}")
            shown = now
    if total > 0 and shown > start:
        show(f"building: {finished} of {total} in {clock() - start:.0f} s")


def main(preset: str, jobs: str, *targets: str) -> int:
    command = ["cmake", "--build", "--preset", preset, "--target", *targets, "-j", jobs]
    if sys.stdout.isatty():
        return subprocess.run(command, env={"NINJA_STATUS": "[%f of %t, %es] ", **os.environ}).returncode
    with subprocess.Popen(command, env={**os.environ, "NINJA_STATUS": "[%f/%t] "}, text=True, errors="replace",
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT) as build:
        assert build.stdout
        follow(lines(build.stdout, INTERVAL), lambda line: print(line, flush=True))
    return build.returncode


if __name__ == "__main__":
    try:
        sys.exit(main(*sys.argv[1:]))
    except KeyboardInterrupt:
        sys.exit(130)
