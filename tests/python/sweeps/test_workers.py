"""Workers that die, refuse, or are gone: a lost worker costs its chunk, and the bytes stay."""
import dataclasses
import os
import pickle
import subprocess
import sys
from concurrent.futures import BrokenExecutor, Future, ThreadPoolExecutor
from pathlib import Path

import psutil
import pytest
from cases import failures, processes, small_chunks, sweep  # noqa: F401

import stiefel
from stiefel._sweep import worker
from stiefel._sweep.plan import Asked, Task

pytestmark = pytest.mark.usefixtures("small_chunks")


class KilledWorker(Exception):
    """As Dask raises it: the type is known by its name."""


class Submitting(ThreadPoolExecutor):
    """Gives each task of a chunk, with its number from 1, to `change`, which returns another task or raises what the task or
    the executor does."""

    def __init__(self, change):
        super().__init__(2)
        self.change, self.count = change, 0

    def submit(self, function, task):
        self.count += function is worker.compute
        try:
            return super().submit(function, function is worker.compute and self.change(self.count, task) or task)
        except (KilledWorker, ZeroDivisionError) as error:
            failed = Future()
            failed.set_exception(error)
            return failed


def server_of_this_process():
    return worker._own._by_process[os.getpid()].server.process.pid


def test_a_lost_worker_costs_its_chunk(monkeypatch):
    """Dask knows a task by its content: one that failed fails for ever."""
    monkeypatch.setattr(worker, "PAUSE", 0.01)
    known, hold, ends = set(), worker._own.hold, []

    def held(share):
        found = hold(share)
        if ends:  # with the server in hand, because one that ends between two chunks costs none
            ends.clear()
            found.server.process.kill()
            found.server.process.wait()
        return found

    monkeypatch.setattr(worker._own, "hold", held)

    def lose(count, task):
        if count in (4, 5):
            known.add(pickle.dumps(task))
        if pickle.dumps(task) in known:
            raise KilledWorker
        if count == 9:
            ends.append(count)
        return dataclasses.replace(task, numerics_id="0" * 16) if count in (1, 12) else None

    with Submitting(lose) as threads:
        found = sweep(executor=threads)
    assert found.attrs["sha256"] == sweep().attrs["sha256"]
    assert failures(found)["KilledWorker"] == 2 and failures(found)["LostServer"] >= 3


@pytest.mark.parametrize("error, said", [
    (KilledWorker("task"), "the chunk of points 0 to 3 failed 16 times, at last with KilledWorker: task; {} of 15 chunks are done"),
    (BrokenExecutor("no more"), "the executor takes no more tasks: BrokenExecutor: no more; {} of 15 chunks are done"),
    (ZeroDivisionError("on purpose"), "on purpose"),
])
def test_what_is_done_is_kept_when_the_sweep_cannot_go_on(error, said):
    poisoned = []

    def fail(count, task):
        if count == (1 if isinstance(error, KilledWorker) else 14):
            poisoned.append(task.scene)
        if task.scene in poisoned:
            raise error

    with Submitting(fail) as threads, pytest.raises((stiefel.SweepFailed, ZeroDivisionError)) as caught:
        sweep(executor=threads)
    done = (caught.value.partial["outcome"].values == 1).sum()
    assert done and str(caught.value) == said.format(done // 4)


def test_a_pool_whose_workers_die_is_not_made_anew():
    with processes(1, initializer=os._exit, initargs=(1,)) as pool:
        with pytest.raises(stiefel.SweepFailed, match="the executor takes no more tasks: BrokenProcessPool: "):
            sweep(executor=pool)


POOL = f"""
import sys
sys.path.insert(0, {str(Path(__file__).parent)!r})
from cases import processes, sweep
from test_workers import server_of_this_process

if __name__ == "__main__":
    with processes(1) as one, processes(1) as other:
        for pool in (one, other):
            sweep(executor=pool)
            print(*pool._processes, pool.submit(server_of_this_process).result(), flush=True)
        sys.stdin.read()
"""


def test_the_workers_of_a_client_that_was_killed_end_with_their_servers():
    program = subprocess.Popen([sys.executable, "-c", POOL], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    left = [psutil.Process(int(pid)) for _ in range(2) for pid in program.stdout.readline().split()]
    assert len(left) == 4
    program.kill()
    program.wait()
    assert psutil.wait_procs(left, timeout=300)[1] == []


def test_a_worker_has_its_share_of_the_machine(monkeypatch):
    monkeypatch.delenv("SLURM_CPUS_PER_TASK", raising=False)
    monkeypatch.setattr(os, "cpu_count", lambda: 8)
    machine, task = psutil.virtual_memory().total, Task(b"", Asked(1, 0, 1, {}))
    assert worker.share_of(task) == (1, pytest.approx(0.75 / 8 * machine, rel=0.02))
    assert worker.share_of(dataclasses.replace(task, threads=2)) == (2, pytest.approx(0.75 / 4 * machine, rel=0.02))
    assert worker.share_of(dataclasses.replace(task, threads=0)) == (0, None)
    monkeypatch.setenv("SLURM_CPUS_PER_TASK", "4")
    assert worker.share_of(task) == (4, pytest.approx(0.75 / 2 * machine, rel=0.02))
