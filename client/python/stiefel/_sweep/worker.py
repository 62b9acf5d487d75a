"""A worker: computes tasks with its own server, which it starts for the first task and keeps."""
from __future__ import annotations

import os
import socket
import sys
import time
from dataclasses import replace
from typing import Any, Optional, Union

from stiefel import v1 as pb
from stiefel.client import Client
from stiefel.errors import CorruptReply, DeadlineExceeded, NotFound, Unavailable
from stiefel._sweep.chunks import Task
from stiefel._sweep.failures import LostServer, OtherNumerics
from stiefel._sweep.orphans import end_with_parent
from stiefel._sweep.own_server import OwnServer, Share
from stiefel._sweep.reduction import Reduced, reduce
from stiefel._sweep.result import canonical
from stiefel._sweep.shared_store import Written, write_if_seen

REFUSAL = 1.0  #: seconds that a refused task takes, so that a worker of another build does not get all tasks

_own = OwnServer()


def compute(task: Task) -> Union[Reduced, Written]:
    """Returns the task's statistics, computed by this process's own server, or their mark if this process wrote them
    into the store. Raises LostServer and OtherNumerics."""
    end_with_parent()
    reduced = _own.use(lambda client: compute_at(client, task), share_of(task))
    if task.place is None:
        return reduced
    written = write_if_seen(task.place, canonical(reduced))
    return replace(written, warnings=reduced.warnings) if isinstance(written, Written) else reduced


def compute_at(client: Client, task: Task) -> Reduced:
    """Returns the task's statistics, computed by the server of `client`. Raises LostServer and OtherNumerics."""
    try:
        return reduce(client, task.ensemble(), pb.SummarizeRequest.FromString(task.request), task.numerics_id, task.timeout)
    except OtherNumerics:
        time.sleep(REFUSAL)
        raise
    except (Unavailable, NotFound, CorruptReply, DeadlineExceeded) as error:
        raise LostServer(f"{client.address} on {socket.gethostname()}: {error.message}") from None


def own_server() -> OwnServer:
    """Returns the server of this process."""
    return _own


def share_of(task: Task) -> Share:
    """Returns the part of its machine that this worker may use: what the sweep says, else what the scheduler gave
    it."""
    if task.home == here():
        return Share(task.threads or 0)
    given = scheduled()
    if task.threads is None:
        return given
    return Share(task.threads, given.memory) if task.threads else Share(0)


def scheduled() -> Share:
    """Returns what Dask, Ray or Slurm gave this process; one thread if none of them did. The server gets three quarters
    of the memory and leaves the rest to the worker. Without a limit, the memory is the machine's in proportion to the
    cores."""
    threads = int(os.environ.get("SLURM_CPUS_PER_TASK", "1"))
    memory: Optional[float] = None
    if "distributed" in sys.modules:
        from distributed import get_worker

        try:
            worker = get_worker()
            threads, memory = int(worker.state.nthreads), worker.memory_manager.memory_limit
        except (ValueError, AttributeError):
            pass  # this is not a task of Dask
    elif "ray" in sys.modules:
        ray: Any = sys.modules["ray"]
        if ray.is_initialized():
            resources = ray.get_runtime_context().get_assigned_resources()
            threads, memory = max(int(resources.get("CPU", 1)), 1), resources.get("memory")
    if not memory:
        machine = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
        memory = machine * min(threads / (os.cpu_count() or 1), 1)
    return Share(threads, int(0.75 * memory))


def here() -> tuple[str, int]:
    """Returns the name of this host and the id of this process."""
    return socket.gethostname(), os.getpid()
