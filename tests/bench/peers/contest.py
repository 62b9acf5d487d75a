"""Compares our methods with Boost.odeint and the packages of peers.txt, on the same bodies at the same accuracy.

Measures the cost of a given attitude error after many rotations, with each contestant's best setting, and the cost of a
step of many bodies. Gives rows for the table and curves for the picture.
"""
from __future__ import annotations

import sys
from dataclasses import asdict, dataclass
from pathlib import Path
from statistics import median
from typing import Optional

from peers import ensemble, work_precision
from peers.contestant import Body, Contestant, everybody
from peers.work_precision import Motion, Point

BODIES = (Body("box", (0.52 / 12, 0.4 / 12, 0.2 / 12), (1.0, 2.0, 3.0)),
          Body("I = (.345, .653, 1)", (0.345, 0.653, 1.0), (1.8 / 0.345, 0.4 / 0.653, -0.9)))
TARGET = 1e-10
_BOUND = 1 / 5
# The packages to which the bound applies.
_JUDGED = ("odeint", "heyoka", "SciPy", "MuJoCo")
# In seconds; a contestant that takes longer runs only once.
_LONG = 1.0


@dataclass(frozen=True)
class Counts:
    rotations: int
    repeats: int
    patience: float
    bodies: int
    steps: int
    seconds: float


FULL = Counts(rotations=1000, repeats=7, patience=8, bodies=256, steps=2000, seconds=0.1)
SMOKE = Counts(rotations=2, repeats=1, patience=0.05, bodies=4, steps=10, seconds=0)


def measure(program: Path, python: Optional[Path], counts: Counts) -> tuple[list[dict], dict]:
    """Returns the rows of the table and the curves of the picture."""
    contestants = everybody(program, python)
    reference = next(c for c in contestants if c.package == "reference")
    contestants.remove(reference)
    rows, curves = [], {}
    for body in BODIES:
        motion = work_precision.motion_of(body, counts.rotations, reference)
        print(f"  {body.name}: reference known to {motion.uncertainty:.1e}", file=sys.stderr)
        # Rollouts are for many bodies, and single precision does not reach 1e-10.
        alone = [c for c in contestants if "rollout" not in c.name and not c.name.endswith("float")]
        measured = {c.title: _curve(c, motion, counts) for c in alone}
        reached = {c: point for c in contestants if c.title in measured
                   if (point := work_precision.reach(c, motion, measured[c.title], TARGET))}
        rows += _rows(motion, reached, counts)
        curves[body.name] = {
            "moments": body.moments, "angular_velocity": body.angular_velocity, "time": motion.time,
            "reference_uncertainty": motion.uncertainty,
            "reached": {c.title: asdict(point) for c, point in reached.items()},
            "curves": {title: [asdict(p) for p in points] for title, points in measured.items()}}
    rows += ensemble.measure(contestants, counts.bodies, counts.steps, counts.seconds, counts.repeats)
    for contestant in (reference, *contestants):
        contestant.process.stop()
    return rows, {"target": TARGET, "rotations": counts.rotations, "contestants": [_about(c) for c in contestants],
                  "bodies": curves}


def _curve(contestant: Contestant, motion: Motion, counts: Counts) -> list[Point]:
    points = work_precision.curve(contestant, motion, TARGET, counts.patience)
    best = f"{min(p.attitude for p in points):.1e}" if points else "nothing"
    print(f"  {motion.body.name}: {contestant.title}, {len(points)} points, best {best}", file=sys.stderr)
    return points


def _rows(motion: Motion, reached: dict[Contestant, Point], counts: Counts) -> list[dict]:
    """Compares our cheapest contestant with the cheapest of each package. The bound applies to the best judged one."""
    def cheapest(contestants: list[Contestant]) -> Optional[Contestant]:
        return min(contestants, key=lambda c: reached[c].seconds, default=None)

    ours = cheapest([c for c in reached if c.ours])
    if ours is None:
        return []
    packages = sorted({c.package for c in reached} - {"stiefel"})
    rivals = [cheapest([c for c in reached if c.package == package]) for package in packages]
    seconds: dict[Contestant, list[tuple[float, float]]] = {rival: [] for rival in rivals}
    for repeat in range(counts.repeats):
        our = _milliseconds(ours, motion, reached)
        for rival in rivals:
            if repeat == 0 or reached[rival].seconds < _LONG:
                seconds[rival].append((our, _milliseconds(rival, motion, reached)))
    ranked = sorted(rivals, key=lambda rival: median(theirs for _, theirs in seconds[rival]))
    best = next((rival for rival in ranked if rival.package in _JUDGED), None)
    return [{"name": f"Attitude to {TARGET:g} after {motion.rotations} rotations, {motion.body.name}, {ours.title}",
             "unit": "ms", "rival": rival.title, "bound": _BOUND if rival is best else None,
             "ours": [ours for ours, _ in seconds[rival]], "theirs": [theirs for _, theirs in seconds[rival]]}
            for rival in ranked]


def _milliseconds(contestant: Contestant, motion: Motion, reached: dict[Contestant, Point]) -> float:
    return 1e3 * contestant.integrate([motion.body], motion.time, reached[contestant].setting).seconds


def _about(contestant: Contestant) -> dict:
    return {"title": contestant.title, "package": contestant.package, "version": contestant.version,
            "setting": contestant.setting, "work": contestant.counted}


def table(data: dict) -> str:
    """Returns a table with the cost of each contestant at the target, cheapest first, and where the others stopped."""
    counted = {c["title"]: c["work"] for c in data["contestants"]}
    lines = ["| body | contestant | setting | attitude error, rad | momentum error | ms | work |", "|" + "---|" * 7]
    for body, found in data["bodies"].items():
        reached = sorted(found["reached"].items(), key=lambda item: item[1]["seconds"])
        for title, p in reached:
            lines.append(_line(body, title, p, f"{p['work']} {counted[title]}" if p["work"] else ""))
        for title, points in found["curves"].items():
            if title in found["reached"] or not points:
                continue
            best = min(points, key=lambda p: p["attitude"])
            needed = work_precision.seconds_needed([Point(**p) for p in points], data["target"])
            lines.append(_line(body, title, best, f"not reached: about {needed:.0f} s would be needed"
                               if needed < 1e4 else "not reached"))
    return "\n".join(lines)


def _line(body: str, title: str, p: dict, remark: str) -> str:
    setting = f"{p['setting']:.0f}" if p["setting"] >= 1 else f"{p['setting']:.1e}"
    return (f"| {body} | {title} | {setting} | {p['attitude']:.1e} | {p['momentum']:.1e} | {1e3 * p['seconds']:.3g} "
            f"| {remark} |")
