"""A rival in Python: contestants that integrate bodies, and the protocol on stdin and stdout, as in contestants.cc.

A rival first writes a line that tells who is there, then answers each task on its stdin:
{"contestant", "bodies": [{"moments", "angular_velocity"}], "time", "setting"}.
"""
from __future__ import annotations

import json
import sys
import time
from dataclasses import dataclass
from typing import Callable, Iterable

Vector = list[float]


@dataclass(frozen=True)
class Body:
    """Moments of inertia in kg m²; ω in rad/s, body axes, which lie along those of space at t = 0."""
    moments: Vector
    angular_velocity: Vector


@dataclass(frozen=True)
class Task:
    """The setting is a number of steps, or a tolerance."""
    bodies: list[Body]
    time: float
    setting: float

    @property
    def body(self) -> Body:
        body, = self.bodies
        return body

    @property
    def steps(self) -> int:
        return round(self.setting)


@dataclass(frozen=True)
class End:
    """The quaternion of the attitude, w first, and ω in body axes."""
    attitude: Vector
    angular_velocity: Vector


@dataclass(frozen=True)
class Run:
    """A task prepared: what is timed, what it took and where the bodies are afterwards."""
    advance: Callable[[], None]
    work: Callable[[], int]
    ends: Callable[[], list[End]]


@dataclass(frozen=True)
class Contestant:
    """`setting` is "steps" or "tolerance", `work` what is counted."""
    name: str
    setting: str
    work: str
    prepare: Callable[[Task], Run]


def serve(package: str, version: str, contestants: Iterable[Contestant]) -> None:
    by_name = {contestant.name: contestant for contestant in contestants}
    # The output of the packages must not mix with the answers.
    answers, sys.stdout = sys.stdout, sys.stderr

    def write(what: object) -> None:
        print(json.dumps(what), file=answers, flush=True)

    write([{"package": package, "version": version, "name": c.name, "setting": c.setting, "work": c.work}
           for c in by_name.values()])
    for line in sys.stdin:
        request = json.loads(line)
        prepare = by_name[request.pop("contestant")].prepare
        try:
            write(_answer(prepare(Task(**{**request, "bodies": [Body(**body) for body in request["bodies"]]}))))
        except (RuntimeError, ValueError) as error:
            write({"failed": str(error)})


def _answer(run: Run) -> dict:
    """Processor time of all threads: some packages step on one of their own."""
    start = time.process_time()
    run.advance()
    seconds = time.process_time() - start
    return {"seconds": seconds, "work": run.work(), "ends": [vars(end) for end in run.ends()]}
