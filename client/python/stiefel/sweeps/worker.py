"""A worker: computes tasks at a server of its own, which it starts with the first and keeps."""
from __future__ import annotations

import os
import socket
import sys
import time

from stiefel import v1 as pb
from stiefel.client import Client
from stiefel.errors import CorruptReply, DeadlineExceeded, NotFound, Unavailable
from stiefel.sweeps.chunks import Task
from stiefel.sweeps.failures import LostServer, OtherNumerics
from stiefel.sweeps.own_server import OwnServer
from stiefel.sweeps.reduction import Reduced, reduce

REFUSAL = 1.0  #: seconds that a refused task takes, so that a worker of another build does not draw all tasks

_own = OwnServer()


def compute(task: Task) -> Reduced:
    """The task's statistics, from this process's own server. LostServer, OtherNumerics."""
    return _own.use(lambda client: compute_at(client, task), threads_of(task))


def compute_at(client: Client, task: Task) -> Reduced:
    """The task's statistics from the server of `client`. LostServer, OtherNumerics."""
    try:
        return reduce(client, task.ensemble(), pb.SummarizeRequest.FromString(task.request), task.numerics_id, task.timeout)
    except OtherNumerics:
        time.sleep(REFUSAL)
        raise
    except (Unavailable, NotFound, CorruptReply, DeadlineExceeded) as error:
        raise LostServer(f"{client.address} on {socket.gethostname()}: {error.message}") from None


def own_server() -> OwnServer:
    """The server of this process."""
    return _own


def threads_of(task: Task) -> int:
    """The share of this worker: what the sweep says, else what the scheduler gave it; 0 is every core."""
    if task.threads is not None:
        return task.threads
    return 0 if task.home == here() else scheduled_threads()


def scheduled_threads() -> int:
    """The threads that Dask, Ray or Slurm gave this process; 1 where none of them did."""
    if "distributed" in sys.modules:
        from distributed import get_worker

        try:
            worker = get_worker()
            return int(getattr(worker, "state", worker).nthreads)
        except ValueError:
            pass  # no task of Dask
    if "ray" in sys.modules:
        import ray

        if ray.is_initialized():
            return max(int(ray.get_runtime_context().get_assigned_resources().get("CPU", 1)), 1)
    return int(os.environ.get("SLURM_CPUS_PER_TASK", "1"))


def here() -> tuple[str, int]:
    """This host and process."""
    return socket.gethostname(), os.getpid()
