"""Runs the processes that integrate bodies, and gives tasks to the contestants in them."""
from __future__ import annotations

import json
import math
import select
import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import Optional

_REPLY_SECONDS = 300


@dataclass(frozen=True)
class Body:
    """A free body. At t = 0 the body axes coincide with the space axes."""
    name: str
    moments: tuple[float, float, float]
    angular_velocity: tuple[float, float, float]

    @property
    def rotation_period(self) -> float:
        """The duration of a rotation, 2π/‖ω‖ at t = 0."""
        return 2 * math.pi / math.hypot(*self.angular_velocity)


@dataclass(frozen=True)
class Answer:
    """The result of a task: seconds of processor time, work in the contestant's units, and the final quaternions of the
    attitudes and ω."""
    seconds: float
    work: int
    attitudes: list[list[float]]
    angular_velocities: list[list[float]]


class Process:
    """A process of contestants: a rival or contestants.cc. It is started on first use, and again after it died."""

    def __init__(self, command: list[str], folder: Path):
        self._command = command
        self._folder = folder  # MuJoCo writes its warnings to a file in the working folder
        self._process: Optional[subprocess.Popen] = None

    def start(self) -> list[dict]:
        """Starts the process and returns its contestants; none if the package is missing."""
        self._process = subprocess.Popen(self._command, cwd=self._folder, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                         stderr=subprocess.DEVNULL, text=True)
        return self._read() or []

    def ask(self, task: dict) -> dict:
        if self._process is None:
            self.start()
        self._process.stdin.write(json.dumps(task) + "\n")
        self._process.stdin.flush()
        reply = self._read()
        if reply is None:
            self.stop()
            return {"failed": f"it ended, or took longer than {_REPLY_SECONDS} s"}
        return reply

    def _read(self) -> object:
        readable, _, _ = select.select([self._process.stdout], [], [], _REPLY_SECONDS)
        line = self._process.stdout.readline() if readable else ""
        return json.loads(line) if line else None

    def stop(self) -> None:
        if self._process is not None:
            self._process.kill()
            self._process.communicate()
            self._process = None


@dataclass(frozen=True)
class Contestant:
    """A method of a package. `setting`: "steps" or "tolerance"; `counted`: the unit of its work, "steps" or
    "evaluations"."""
    process: Process
    package: str
    version: str
    name: str
    setting: str
    counted: str

    @property
    def ours(self) -> bool:
        return self.package == "stiefel"

    @property
    def title(self) -> str:
        return self.name if self.ours else f"{self.package} {self.name}"

    def integrate(self, bodies: list[Body], time: float, setting: float) -> Optional[Answer]:
        """Integrates the bodies. Returns None if that fails, for example because the step is too long."""
        reply = self.process.ask({
            "contestant": self.name, "time": time, "setting": setting,
            "bodies": [{"moments": b.moments, "angular_velocity": b.angular_velocity} for b in bodies]})
        if "failed" in reply:
            return None
        return Answer(reply["seconds"], reply["work"], [end["attitude"] for end in reply["ends"]],
                      [end["angular_velocity"] for end in reply["ends"]])


def everybody(program: Path, python: Optional[Path]) -> list[Contestant]:
    """Returns our contestants, Boost.odeint's, the reference and, with `python`, those of the packages."""
    commands = [[str(program.absolute())]]
    if python is not None:
        commands += [[str(python.absolute()), str(rival)] for rival in sorted(Path(__file__).parent.glob("rival_*.py"))]
    found = []
    for command in commands:
        process = Process(command, program.parent)
        for c in process.start():
            found.append(Contestant(process, c["package"], c["version"], c["name"], c["setting"], c["work"]))
    return found


def angle_between(a: list[float], b: list[float]) -> float:
    """Returns the angle in radians between two attitudes, given as quaternions of about unit length. It is accurate for
    the smallest angles."""
    w, x, y, z = a
    s, i, j, k = b
    axis = (s * x - w * i + z * j - y * k, s * y - w * j + x * k - z * i, s * z - w * k + y * i - x * j)
    length = math.hypot(*axis) / (math.hypot(*a) * math.hypot(*b))
    return 2 * math.asin(min(1.0, length))
