"""Compares the processor time per body and step for many free bodies at once with MuJoCo's."""
from __future__ import annotations

import itertools
import math
import random
from statistics import median

from peers.contestant import Body, Contestant

_H_OMEGA = 0.05
_BOUND = 1 / 50


def bodies_of(count: int) -> list[Body]:
    """Returns seeded boxes with ‖ω‖ = 1."""
    chance = random.Random(1)

    def body(index: int) -> Body:
        a, b, c = (chance.uniform(0.5, 1.5) ** 2 for _ in range(3))
        omega = [chance.gauss(0, 1) for _ in range(3)]
        length = math.hypot(*omega)
        return Body(f"box {index}", ((b + c) / 12, (c + a) / 12, (a + b) / 12), tuple(x / length for x in omega))

    return [body(index) for index in range(count)]


def measure(contestants: list[Contestant], count: int, steps: int, seconds: float, repeats: int) -> list[dict]:
    """Returns a row for each of MuJoCo's ways, compared with our cheapest contestant, in double and in float."""
    bodies = bodies_of(count)

    def nanoseconds(contestant: Contestant, steps: int = steps) -> float:
        """Returns nanoseconds per body and step, from a run long enough for the processor to reach its full clock."""
        answer = contestant.integrate(bodies, steps * _H_OMEGA, steps)
        if not answer:
            return math.inf
        if answer.seconds < seconds:
            return nanoseconds(contestant, steps * math.ceil(1.5 * seconds / answer.seconds))
        return 1e9 * answer.seconds / (steps * count)

    candidates = [c for c in contestants if c.ours and c.setting == "steps"]
    cost = {c: median(nanoseconds(c) for _ in range(min(3, repeats))) for c in candidates}
    best = [min((c for c in candidates if c.name.endswith("float") == in_float), key=cost.get)
            for in_float in (False, True)]
    rows = []
    for rival, ours in itertools.product((c for c in contestants if c.package == "MuJoCo"), best):
        pairs = [(nanoseconds(ours), nanoseconds(rival)) for _ in range(repeats)]
        rows.append({"name": f"Body-step of {count} free bodies, N = 3, {ours.title}", "unit": "ns",
                     "rival": rival.title, "bound": _BOUND, "ours": [a for a, _ in pairs], "theirs": [b for _, b in pairs]})
    return sorted(rows, key=lambda row: median(row["theirs"]))
