"""Measures error over cost of every contestant on one body, and the cost of a given error."""
from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Iterator, Optional

from peers.contestant import Answer, Body, Contestant, angle_between

_REFERENCE_TOLERANCE = 1e-21
# In seconds. A shorter run is repeated, because the first one waits for its memory.
_COLD = 0.05
# A curve ends at this multiple of the cost at the target, or at rounding.
_BEYOND = 4
_LEAST_TOLERANCE = 1e-16
_STEPS_OF_A_ROTATION = 4
_REFINEMENTS = 6
# The first settings may be too coarse. A contestant that fails this often gets no finer settings for this body.
_FAILURES = 8


@dataclass(frozen=True)
class Point:
    """A run with one setting: the error of the attitude in radians, the error of the momentum relative to its length,
    the cost, and the work as the contestant counts it."""
    setting: float
    seconds: float
    work: int
    attitude: float
    momentum: float


@dataclass(frozen=True)
class Motion:
    """A body over a number of rotations, with its exact final state."""
    body: Body
    rotations: int
    attitude: list[float]
    angular_velocity: list[float]
    uncertainty: float

    @property
    def time(self) -> float:
        return self.rotations * self.body.rotation_period

    def point(self, contestant: Contestant, setting: float) -> Optional[Point]:
        answer = contestant.integrate([self.body], self.time, setting)
        if answer is None:
            return None
        if answer.seconds < _COLD:
            answer = min(answer, contestant.integrate([self.body], self.time, setting), key=lambda a: a.seconds)
        m, exact = ([I * x for I, x in zip(self.body.moments, omega)]
                    for omega in (answer.angular_velocities[0], self.angular_velocity))
        point = Point(setting, answer.seconds, answer.work, angle_between(answer.attitudes[0], self.attitude),
                      math.dist(m, exact) / math.hypot(*exact))
        return point if math.isfinite(point.attitude) and math.isfinite(point.momentum) else None


def motion_of(body: Body, rotations: int, reference: Contestant) -> Motion:
    """Computes the exact motion of a body. Its uncertainty is the change that ten times the tolerance makes."""
    def end(tolerance: float) -> Answer:
        return reference.integrate([body], rotations * body.rotation_period, tolerance)
    exact, rougher = end(_REFERENCE_TOLERANCE), end(10 * _REFERENCE_TOLERANCE)
    return Motion(body, rotations, exact.attitudes[0], exact.angular_velocities[0],
                  angle_between(exact.attitudes[0], rougher.attitudes[0]))


def curve(contestant: Contestant, motion: Motion, target: float, patience: float) -> list[Point]:
    """Measures a contestant from coarse to fine, with factors of √2 in the step or √10 in the tolerance. Ends when
    rounding limits the error, well past the cost at the target, or when the points have taken `patience` seconds."""
    points: list[Point] = []
    failures = 0
    for setting in _ladder(contestant, motion):
        point = motion.point(contestant, setting)
        if point is None:
            failures += 1
            if failures == _FAILURES:
                break
            continue
        points.append(point)
        reached = min((p.seconds for p in points if p.attitude <= target), default=math.inf)
        if _at_its_floor(points) or point.seconds > _BEYOND * reached or sum(p.seconds for p in points) > patience:
            break
    return points


def seconds_needed(points: list[Point], target: float) -> float:
    """Extrapolates the last decrease of the error over cost and returns the cost at the target."""
    if len(points) < 3:
        return math.inf
    first, last = points[-3], points[-1]
    if last.attitude >= first.attitude or last.seconds <= first.seconds:
        return math.inf
    order = math.log(first.attitude / last.attitude) / math.log(last.seconds / first.seconds)
    return last.seconds * (last.attitude / target) ** (1 / order)


def _at_its_floor(points: list[Point]) -> bool:
    """Returns whether the error no longer falls. The last five points decide, because curves of methods whose order
    depends on the tolerance have stairs of up to four points."""
    errors, stairs = [point.attitude for point in points], 5
    return len(errors) > stairs and min(errors[:-stairs]) <= min(errors[-stairs:]) and min(errors) < 1e-6


def _ladder(contestant: Contestant, motion: Motion) -> Iterator[float]:
    if contestant.setting == "steps":
        for k in range(30):
            yield round(motion.rotations * _STEPS_OF_A_ROTATION * 2 ** (k / 2))
    else:
        for k in range(6, 1 - 2 * round(math.log10(_LEAST_TOLERANCE))):
            yield 10 ** (-k / 2)


def reach(contestant: Contestant, motion: Motion, points: list[Point], target: float) -> Optional[Point]:
    """Finds the cheapest setting that keeps the target, between two points of the curve."""
    first = next((i for i, p in enumerate(points) if p.attitude <= target), None)
    if first is None:
        return None
    kept = points[first]
    missed = points[first - 1].setting if first > 0 else kept.setting
    for _ in range(_REFINEMENTS):
        setting = math.sqrt(missed * kept.setting)
        if contestant.setting == "steps":
            setting = round(setting)
        point = motion.point(contestant, setting)
        if point is not None and point.attitude <= target:
            kept = point
        else:
            missed = setting
    return kept
