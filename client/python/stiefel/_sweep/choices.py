"""Methods for points whose scene names none: the recommended method, or one chosen for a tolerance."""
from __future__ import annotations

from dataclasses import replace
from typing import Callable

import numpy as np
from numpy.typing import NDArray

from stiefel import v1 as pb
from stiefel._sweep.axes import Axes
from stiefel._sweep.chunks import LARGEST, Task
from stiefel._sweep.groups import Group, task_of
from stiefel._sweep.resolution import Question, Resolved

#: A function of a number of questions, a function that returns question k, and one that takes the answer to question k.
AskAll = Callable[[int, Callable[[int], Question], Callable[[int, "list[Resolved]"], None]], None]
POINTS = 64  #: points per question; each takes a few milliseconds to a second


def ask(question: Question, ask_all: AskAll) -> list[Resolved]:
    """Asks one question and returns its answer."""
    answers: dict[int, list[Resolved]] = {}
    ask_all(1, lambda k: question, answers.__setitem__)
    return answers[0]


def with_recommended(group: Group, first: Resolved, template: Task, axes: Axes, order: NDArray[np.int64],
                     ask_all: AskAll) -> tuple[Group, Resolved]:
    """Returns the group with the recommended method of its points as an ensemble, with as many substeps as the most
    demanding point needs, and the answer that has it. The method does not depend on how the group is cut into chunks.
    `first`: the answer for the first point alone."""
    if not first.method or group.scene.HasField("method"):
        return group, first
    answers = [ask(Question((task_of(template, axes, group.scene, order[begin:min(begin + LARGEST, group.end)], 0),)), ask_all)[0]
               for begin in range(group.begin, group.end, LARGEST)]
    chosen = max(answers, key=lambda answer: answer.rank)
    scene = pb.Scene()
    scene.CopyFrom(group.scene)
    scene.method.ParseFromString(chosen.method)
    scene.method.substeps = max(pb.Method.FromString(answer.method).substeps for answer in answers)
    return replace(group, scene=scene), chosen


def by_choice(group: Group, template: Task, axes: Axes, order: NDArray[np.int64],
              ask_all: AskAll) -> list[tuple[Group, Resolved]]:
    """Divides the group by the methods that are chosen for the tolerance at each point, so that each point has the
    method and the bits of a sweep of that point alone. Reorders `order` so that the points of a method stand together.
    Raises InvalidArgument that names a point at which no method meets the tolerance."""
    points = order[group.begin:group.end].copy()
    chosen: dict[bytes, tuple[int, Resolved]] = {}  # method to its first point, counted within the group, and answer
    methods: list[bytes] = [b""] * len(points)

    def question(k: int) -> Question:
        some = points[k * POINTS:(k + 1) * POINTS]
        return Question(tuple(task_of(template, axes, group.scene, some[i:i + 1], int(some[i])) for i in range(len(some))), True)

    def take(k: int, answers: list[Resolved]) -> None:
        for i, one in enumerate(answers, k * POINTS):
            chosen[one.method] = min(chosen.get(one.method, (i, one)), (i, one), key=lambda entry: entry[0])
            methods[i] = chosen[one.method][1].method

    ask_all(-(-len(points) // POINTS), question, take)
    names, begin, found = sorted(chosen), group.begin, np.array(methods, object)
    result: list[tuple[Group, Resolved]] = []
    for name in names:
        theirs = points[found == name]
        order[begin:begin + len(theirs)] = theirs
        scene = pb.Scene()
        scene.CopyFrom(group.scene)
        scene.method.ParseFromString(name)
        scene.ClearField("tolerance")
        scene.ClearField("horizon")
        scene.ClearField("verification")
        result.append((Group(scene, begin, begin + len(theirs)), chosen[name][1]))
        begin += len(theirs)
    return result
