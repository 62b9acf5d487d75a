"""A rival in Python: contestants that integrate bodies, and their protocol on stdin and stdout, as in contestants.cc.

A rival first writes a line with its contestants, then answers each task that it reads from stdin:
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
    """A free body: moments of inertia in kg m², ω in rad/s in body axes. At t = 0 the body axes coincide with the space
    axes."""
    moments: Vector
    angular_velocity: Vector


@dataclass(frozen=True)
class Task:
    """Bodies to be integrated from 0 to `time`. `setting`: a number of steps, or a tolerance."""
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
    """The final state of a body: the quaternion of its attitude, w first, and ω in body axes."""
    attitude: Vector
    angular_velocity: Vector


@dataclass(frozen=True)
class Run:
    """A prepared task: the function that is timed, and functions that return its work and the final states."""
    advance: Callable[[], None]
    work: Callable[[], int]
    ends: Callable[[], list[End]]


@dataclass(frozen=True)
class Contestant:
    """A method that integrates bodies. `setting`: "steps" or "tolerance"; `work`: the unit of its work."""
    name: str
    setting: str
    work: str
    prepare: Callable[[Task], Run]


def serve(package: str, version: str, contestants: Iterable[Contestant]) -> None:
    by_name = {contestant.name: contestant for contestant in contestants}
    # Output of the packages must not mix with the answers.
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
    """Returns the answer with the processor time of all threads, because some packages step on their own thread."""
    start = time.process_time()
    run.advance()
    seconds = time.process_time() - start
    return {"seconds": seconds, "work": run.work(), "ends": [vars(end) for end in run.ends()]}
