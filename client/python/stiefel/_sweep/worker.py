"""A worker: computes tasks with its own server, which it starts for the first task and keeps."""
from __future__ import annotations

import math
import multiprocessing
import os
import signal
import socket
import sys
import threading
import time
from contextlib import suppress
from typing import Any, Callable, TypeVar

import numpy as np

from stiefel import v1 as pb
from stiefel._results.base import Array
from stiefel._sweep.own_server import GONE, LostServer, OwnServer, Share
from stiefel._sweep.plan import Resolved, Task
from stiefel._client import Client
from stiefel.errors import SCENE_WARNINGS
from stiefel.results import Summary
from stiefel._session import Session

PAUSE = 0.5  #: seconds before a worker without a usable server takes another task, so that it does not get them all
T = TypeVar("T")

_own = OwnServer()
_watched = 0  # the id of the process in which a thread waits for the parent's end; 0: none


def compute(task: Task, servers: Any = _own) -> tuple[dict[str, Array], list[str]]:
    """Returns the statistics of the task's ensemble, "outcome" and "last_step", each (members, ...), and the server's
    warnings about the scene. Raises LostServer."""
    def statistics(client: Client, session: Session) -> dict[str, Array]:
        asked = task.asked
        found = session.summarize(to=asked.to, quantities=asked.summarize, start=asked.start, every=asked.every)
        outcome = np.array([pb.Outcome.Value(f"OUTCOME_{one}") for one in found.outcomes], "u1")
        return {**_arrays(found), "outcome": outcome, "last_step": found.last_step}

    return _in_session(task, pb.Scene.FromString(task.scene), servers, statistics)


def resolve(task: Task, servers: Any = _own) -> Resolved:
    """Returns what the server says of the task's ensemble, or of the motion if it has one member, before any step is
    computed. A summary of step 0 finds wrong names. Raises LostServer."""
    scene = pb.Scene.FromString(task.scene)
    members = scene.members
    if members == 1:
        scene.ClearField("members")  # the server may choose another method for a single motion

    def resolved(client: Client, session: Session) -> Resolved:
        method: Any = session.scene.get("method", {})
        catalogue = client.describe()
        listed = [(one.method.name, one.method.order) for info in catalogue.systems if info.name == scene.system
                  for one in info.recommended]
        name = method.get("name"), method.get("order", 0)
        arrays = _arrays(session.summarize(to=0, quantities=task.asked.summarize))
        kept = sum(math.prod(array.shape[members > 1:-1]) for name, array in arrays.items() if name.endswith(".quantiles"))
        return Resolved(method, listed.index(name) if name in listed else 0, session.step_price.work / members, kept,
                        catalogue.numerics_id, catalogue.build)

    return _in_session(task, scene, servers, resolved)[0]


def _in_session(task: Task, scene: pb.Scene, servers: Any, function: Callable[[Client, Session], T]) -> tuple[T, list[str]]:
    """Returns what `function` returns of a session of the scene, and the server's warnings about it."""
    warnings: list[str] = []

    def use(client: Client) -> T:
        with client.create(scene) as session:
            numerics_id = session._message.numerics_id
            if task.numerics_id not in ("", numerics_id):
                raise LostServer(f"{client.address} has the numerics id {numerics_id}, the sweep {task.numerics_id}: install one "
                                 "build on all workers")
            return function(client, session)

    _end_with_parent()
    kept = SCENE_WARNINGS.set(warnings)
    try:
        return servers.use(use, share_of(task)), warnings
    except (*GONE, LostServer) as error:
        time.sleep(PAUSE)
        raise LostServer(f"on {socket.gethostname()}: {error.message}") from None
    finally:
        SCENE_WARNINGS.reset(kept)


def _arrays(found: Summary) -> dict[str, Array]:
    return {f"{name}.{statistic}": values for name, of in found.quantities.items() for statistic, values in of.items()}


def share_of(task: Task) -> Share:
    """Returns the part of its machine that this worker may use: the threads of the task, else what Dask, Ray or Slurm gave
    this process, else one thread. The server gets three quarters of the memory and leaves the rest to the worker. Without a
    limit, the memory is the machine's in proportion to the cores."""
    if task.threads == 0:
        return Share(0)
    threads, memory = int(os.environ.get("SLURM_CPUS_PER_TASK", "1")), None
    if "distributed" in sys.modules:
        from distributed import get_worker

        try:
            worker = get_worker()
            threads, memory = int(worker.state.nthreads), worker.memory_manager.memory_limit
        except (ValueError, AttributeError):
            pass  # this is not a task of Dask
    elif "ray" in sys.modules and sys.modules["ray"].is_initialized():
        with suppress(AssertionError):  # of a process that is no worker
            resources = sys.modules["ray"].get_runtime_context().get_assigned_resources()
            threads, memory = max(int(resources.get("CPU", 1)), 1), resources.get("memory")
    threads = threads if task.threads is None else task.threads
    machine = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    return Share(threads, int(0.75 * (memory or machine * min(threads / (os.cpu_count() or 1), 1))))


def _end_with_parent() -> None:
    """Ends a worker of a process pool when its parent was killed. The worker would wait for tasks forever: the pipe from
    which it reads stays open, because the other workers have inherited the other end."""
    global _watched
    parent = multiprocessing.parent_process()
    if parent is not None and _watched != os.getpid():
        _watched = os.getpid()

        def watch() -> None:
            parent.join()
            os.kill(os.getpid(), signal.SIGTERM)

        threading.Thread(target=watch, daemon=True).start()
