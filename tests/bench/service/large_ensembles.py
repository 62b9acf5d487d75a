"""Compares the steps of an ensemble that does not fit into the cache with those of one that does, those of Step with those
of Summarize, and those of two threads with those of one. The bodies are moved by `variational` of order 2.

Arguments: address and process id of a server with two threads, address and id of one with one, repeats, members of the
large ensemble, body-steps per measurement.
"""
from __future__ import annotations

import json
import sys
import time
from typing import Callable

import numpy as np
import stiefel

SMALL = 1024


def bodies(members: int, arithmetic: str) -> dict:
    spins = np.random.default_rng(1).normal(size=(members, 3))
    spins /= np.linalg.norm(spins, axis=1)[:, None]
    return {"system": "rigid_body", "step": 0.05, "members": members,
            "method": {"name": "variational", "order": 2, "arithmetic": arithmetic},
            "body": {"moments": [1, 2, 3], "angular_velocity": spins}}


def processor_seconds(pid: int) -> float:
    """The processor time of a process and all of its threads: Linux numbers the clock of a process so."""
    return time.clock_gettime((~pid << 3) | 2)


class Walk:
    """Steps of one ensemble of a server, by Step and by Summarize."""

    def __init__(self, address: str, pid: int, members: int, arithmetic: str, body_steps: int):
        self.pid, self.members = pid, members
        self.steps = max(body_steps // members, 1)
        self.session = stiefel.Client(address, timeout=None).create(bodies(members, arithmetic))
        self.at = 1
        self.session.step(self.at, fields=["angular_velocity"])

    def step(self) -> None:
        self.at += self.steps
        self.session.step(self.at, fields=["angular_velocity"])

    def by_step(self, clock: Callable[[], float]) -> float:
        """The nanoseconds of a step of a body."""
        start = clock()
        self.step()
        return 1e9 * (clock() - start) / (self.members * self.steps)

    def processor(self) -> float:
        return processor_seconds(self.pid)

    def by_summarize(self) -> float:
        """The same in a summary, without what it takes before its first step."""
        def taken(steps: int) -> float:
            start = self.processor()
            self.session.summarize(steps, quantities={"angular_velocity": "last"}, every=steps)
            return self.processor() - start
        return 1e9 * (taken(5 * self.steps) - taken(self.steps)) / (4 * self.members * self.steps)


def report(name: str, rival: str, pairs: list[tuple[float, float]], bound: float) -> None:
    print(json.dumps({"name": name, "unit": "ns a body-step", "rival": rival, "bound": bound,
                      "ours": [a for a, _ in pairs], "theirs": [b for _, b in pairs]}))


def main(two: str, pid_of_two: str, one: str, pid_of_one: str, repeats: str, members: str, body_steps: str) -> None:
    for arithmetic in ("plain", "compensated"):
        def walk(address: str, pid: str, count: int) -> Walk:
            return Walk(address, int(pid), count, arithmetic, int(body_steps))
        large, alone, small = walk(two, pid_of_two, int(members)), walk(one, pid_of_one, int(members)), walk(two, pid_of_two, SMALL)
        what = f"Step, an ensemble of {members}, {arithmetic}"
        times = range(int(repeats))
        report(f"{what}: processor time", f"an ensemble of {SMALL}",
               [(large.by_step(large.processor), small.by_step(small.processor)) for _ in times], 1.15)
        report(f"{what}: processor time", "Summarize", [(large.by_step(large.processor), large.by_summarize()) for _ in times], 1.15)
        report(f"{what}: time on two threads", "on one",
               [(large.by_step(time.perf_counter), alone.by_step(time.perf_counter)) for _ in times], 1 / 1.8)
        for each in (large, alone, small):
            each.session.delete()


if __name__ == "__main__":
    main(*sys.argv[1:])
