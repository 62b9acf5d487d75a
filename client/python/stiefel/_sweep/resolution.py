"""What a sweep asks workers before it begins: the resolved methods, their prices and the build."""
from __future__ import annotations

import math
from dataclasses import dataclass

from stiefel import v1 as pb
from stiefel.client import Client
from stiefel.errors import DeadlineExceeded, InvalidArgument, NotFound, Unavailable
from stiefel._sweep.chunks import Task
from stiefel._sweep.failures import LostServer, at
from stiefel._sweep.reduction import summary_of, temporary_session
from stiefel._sweep.worker import own_server, share_of


@dataclass(frozen=True, eq=False)
class Question:
    """Ensembles to be resolved, given as tasks. A task with one member is resolved as a single motion."""

    tasks: tuple[Task, ...]
    of_points: bool = False  #: whether each task is the motion of the point `Task.index`, which errors then name


@dataclass(frozen=True)
class Resolved:
    """The answer for one ensemble: its method, the cost of one step of one member, and the build of the server."""

    method: bytes  #: the resolved method as a serialized message; empty for a discrete system
    rank: int  #: the place of the method among those that the server recommends for the system; later ones take more scenes
    step_work: float  #: instructions for one step of one member
    kept: int  #: how many numbers the quantiles keep for one sample of one member
    numerics_id: str
    build: str
    warnings: tuple[str, ...]


def answer(question: Question) -> list[Resolved]:
    """Answers with this process's own server. Raises the errors of CreateSession and Summarize, and LostServer."""
    return own_server().use(lambda client: answer_at(client, question), share_of(question.tasks[0]))


def answer_at(client: Client, question: Question) -> list[Resolved]:
    try:
        catalogue = client.describe()._message
        return [_resolve(client, task, catalogue, question.of_points) for task in question.tasks]
    except (Unavailable, NotFound, DeadlineExceeded) as error:
        raise LostServer(f"{client.address}: {error.message}") from None


def _resolve(client: Client, task: Task, catalogue: pb.DescribeResponse, of_point: bool) -> Resolved:
    try:
        return _resolve_alone(client, task, catalogue)
    except InvalidArgument as error:
        raise (at(error, f"at point {task.index}") if of_point else error) from None


def _rank(method: pb.Method, system: str, catalogue: pb.DescribeResponse) -> int:
    listed = [one.method for info in catalogue.systems if info.name == system for one in info.recommended]
    return next((k for k, one in enumerate(listed) if (one.name, one.order) == (method.name, method.order)), 0)


def _resolve_alone(client: Client, task: Task, catalogue: pb.DescribeResponse) -> Resolved:
    scene = task.ensemble()
    if task.members == 1:
        scene.ClearField("members")  # for a single motion the server may choose a method for its tolerance alone
    with temporary_session(client, scene, task.numerics_id) as session:
        filled_in = session.scene if session.scene.HasField("method") else scene
        method = filled_in.method.SerializeToString(deterministic=True) if filled_in.HasField("method") else b""
        arrays = summary_of(client, session, _without_steps(task), task.members > 1, task.timeout)
        kept = sum(math.prod(array.shape[task.members > 1:-1]) for name, array in arrays.items() if name.endswith(".quantiles"))
        return Resolved(method, _rank(filled_in.method, scene.system, catalogue), session.step_price.work / task.members, kept,
                        session.numerics_id, catalogue.build, tuple(session.warnings))


def _without_steps(task: Task) -> pb.SummarizeRequest:
    """Returns the task's request for step 0 alone, which finds wrong names before any step is computed."""
    request: pb.SummarizeRequest = pb.SummarizeRequest.FromString(task.request)
    setattr(request, "from", 0)
    request.to = 0
    return request
