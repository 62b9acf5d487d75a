"""What a sweep asks of a worker before it begins: the resolved methods, their prices and the build."""
from __future__ import annotations

import math
from dataclasses import dataclass

from stiefel import v1 as pb
from stiefel.client import Client
from stiefel.errors import DeadlineExceeded, InvalidArgument, NotFound, Unavailable
from stiefel.sweeps.chunks import Task
from stiefel.sweeps.failures import LostServer, at
from stiefel.sweeps.reduction import summary_of, temporary_session
from stiefel.sweeps.worker import own_server, share_of


@dataclass(frozen=True, eq=False)
class Question:
    """Ensembles to be resolved, as tasks whose request is not looked at. One of one member is a motion alone.

    of_points: each task is the motion of the point that is its index, which errors then name.
    """

    tasks: tuple[Task, ...]
    of_points: bool = False


@dataclass(frozen=True)
class Resolved:
    """Of one ensemble: its method, what one step of one member costs, and the build that says so."""

    method: bytes  #: the resolved method, as a message; empty for a discrete system
    step_work: float  #: instructions
    kept: int  #: numbers that quantiles keep of one sample of one member
    numerics_id: str
    build: str
    warnings: tuple[str, ...]


def answer(question: Question) -> list[Resolved]:
    """By this process's own server. Raises what CreateSession and Summarize do, and LostServer."""
    return own_server().use(lambda client: answer_at(client, question), share_of(question.tasks[0]))


def answer_at(client: Client, question: Question) -> list[Resolved]:
    try:
        build = client.describe().build
        return [_resolve(client, task, build, question.of_points) for task in question.tasks]
    except (Unavailable, NotFound, DeadlineExceeded) as error:
        raise LostServer(f"{client.address}: {error.message}") from None


def _resolve(client: Client, task: Task, build: str, of_point: bool) -> Resolved:
    try:
        return _resolve_alone(client, task, build)
    except InvalidArgument as error:
        raise (at(error, f"at point {task.index}") if of_point else error) from None


def _resolve_alone(client: Client, task: Task, build: str) -> Resolved:
    scene = task.ensemble()
    if task.members == 1:
        scene.ClearField("members")  # one motion alone may have a tolerance
    with temporary_session(client, scene, task.numerics_id) as session:
        filled_in = session.scene if session.scene.HasField("method") else scene
        method = filled_in.method.SerializeToString(deterministic=True) if filled_in.HasField("method") else b""
        arrays = summary_of(client, session, _without_steps(task), task.members > 1, task.timeout)
        kept = sum(math.prod(array.shape[task.members > 1:-1]) for name, array in arrays.items() if name.endswith(".quantiles"))
        return Resolved(method, session.step_price.work / task.members, kept, session.numerics_id, build,
                        tuple(session.warnings))


def _without_steps(task: Task) -> pb.SummarizeRequest:
    """The request for step 0 alone: what is wrong with its names is found before any step."""
    request: pb.SummarizeRequest = pb.SummarizeRequest.FromString(task.request)
    setattr(request, "from", 0)
    request.to = 0
    return request
