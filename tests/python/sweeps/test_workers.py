"""Workers that die, refuse, or are gone, and sweeps that are cancelled: a lost worker costs its chunk, and the bytes stay."""
import dataclasses
import os
import pickle
import signal
import subprocess
import sys
import time
from concurrent.futures import BrokenExecutor, Future, ThreadPoolExecutor
from pathlib import Path

import psutil
import pytest
from cases import SCENE, failures, processes, small_chunks, sweep  # noqa: F401

import stiefel
from stiefel._sweep import worker
from stiefel._sweep.failures import is_lost_worker
from stiefel._sweep.own_server import Share
from stiefel._sweep.plan import Asked, Task

pytestmark = pytest.mark.usefixtures("small_chunks")


class KilledWorker(Exception):
    """As Dask raises it: the type is known by its name."""


class Submitting(ThreadPoolExecutor):
    """Gives each task of a chunk, counted from 1, to `change`, which returns another task, or raises what the task does."""

    def __init__(self, change, workers=2):
        super().__init__(workers)
        self.change, self.count = change, 0

    def submit(self, function, task):
        if function is not worker.compute:
            return super().submit(function, task)
        self.count += 1
        try:
            return super().submit(function, self.change(self.count, task) or task)
        except KilledWorker as error:
            failed = Future()
            failed.set_exception(error)
            return failed


def server_of_this_process():
    return worker._own._by_process[os.getpid()].server.process


def test_a_killed_server_costs_its_chunks():
    def kill(count, task):
        if count in (9, 18):
            server_of_this_process().kill()

    with Submitting(kill) as threads:
        found = sweep(executor=threads)
    assert found.attrs["sha256"] == sweep().attrs["sha256"] and failures(found)["LostServer"] >= 1


def test_chunks_that_a_scheduler_gave_up_are_given_again_as_other_tasks():
    """Dask knows a task by its content: one that failed fails for ever."""
    known = set()

    def remember(count, task):
        content = pickle.dumps(task)
        if count in (1, 4, 5):
            known.add(content)
        if content in known:
            raise KilledWorker

    with Submitting(remember) as threads:
        found = sweep(executor=threads)
    assert len(known) == 3 == failures(found)["KilledWorker"] and found.attrs["sha256"] == sweep().attrs["sha256"]


def test_a_worker_of_another_build_is_refused(monkeypatch):
    monkeypatch.setattr(worker, "PAUSE", 0.01)
    with Submitting(lambda count, task: dataclasses.replace(task, numerics_id="0" * 16) if count % 2 else None) as threads:
        found = sweep(executor=threads)
    assert found.attrs["sha256"] == sweep().attrs["sha256"] and failures(found)["LostServer"] >= 8


def test_a_chunk_that_kills_its_worker_is_given_up_and_the_rest_is_kept():
    poisoned = []

    def poison(count, task):
        poisoned[:] = poisoned or [task.scene]
        if task.scene in poisoned:
            raise KilledWorker("task")

    with Submitting(poison) as threads, pytest.raises(stiefel.SweepFailed) as caught:
        sweep(executor=threads)
    said = "the chunk of points 0 to 3 failed 16 times, at last with KilledWorker: task; {} of 15 chunks are done"
    outcome = caught.value.partial["outcome"].values
    assert str(caught.value) == said.format((outcome == 1).sum() // 4) and (outcome[:4] == 0).all() and (outcome == 1).any()


@pytest.mark.parametrize("change", ["a task raises", "an executor breaks"])
def test_what_is_done_is_kept_when_the_sweep_cannot_go_on(change):
    def end(count, task):
        if count == 15:
            raise RuntimeError("on purpose") if change == "a task raises" else BrokenExecutor("no more")

    kind = RuntimeError if change == "a task raises" else stiefel.SweepFailed
    with Submitting(end, 1) as threads, pytest.raises(kind, match="on purpose|the executor takes no more tasks: BrokenExecutor: no more; ") as caught:
        sweep(executor=threads)
    assert 0 < (caught.value.partial["outcome"] == 1).sum() < 60


def test_a_pool_whose_worker_was_killed_is_not_made_anew(tmp_path):
    """The caller makes another, and the same call goes on from what is stored."""
    with processes(1) as pool:
        pool.submit(os.getpid).result()
        process, = pool._processes.values()
        submit = pool.submit

        def submit_or_kill(function, task):
            if len(list(tmp_path.glob("store/*.npz"))) > 2:
                process.kill()
            return submit(function, task)
        pool.submit = submit_or_kill
        with pytest.raises(stiefel.SweepFailed, match="takes no more tasks: BrokenProcessPool: .* of 15 chunks are done; they are in the store"):
            sweep(executor=pool, store=tmp_path / "store")
    with processes(1) as pool:
        assert sweep(executor=pool, store=tmp_path / "store").attrs["sha256"] == sweep().attrs["sha256"]


CANCELLED = """
import sys
sys.path.insert(0, {here!r})
import stiefel._sweep.plan
from cases import sweep
stiefel._sweep.plan.LARGEST = 4
try:
    sweep(to=50_000, store=sys.argv[1], threads=1)
except KeyboardInterrupt as error:
    print(error, int((error.partial["outcome"] == 1).sum()))
"""


def test_ctrl_c_ends_a_sweep_which_says_how_far_it_came(tmp_path):
    program = subprocess.Popen([sys.executable, "-c", CANCELLED.format(here=str(Path(__file__).parent)), tmp_path / "store"],
                               stdout=subprocess.PIPE, text=True)
    while not list(tmp_path.glob("store/*.npz")):
        time.sleep(0.01)
    children = psutil.Process(program.pid).children()
    program.send_signal(signal.SIGINT)
    said = program.communicate(timeout=60)[0]
    done = len(list(tmp_path.glob("store/*.npz")))
    assert said == f"{done} of 15 chunks are done; they are in the store, and the same call goes on from there {4 * done}\n"
    assert children and not any(child.is_running() for child in children)


def test_which_errors_are_the_workers():
    lost = [stiefel._sweep.failures.LostServer("gone"), ConnectionResetError(), KilledWorker()]
    others = [stiefel.InvalidArgument("scene"), ValueError(), MemoryError()]
    assert [is_lost_worker(error) for error in (*lost, *others)] == [True] * 3 + [False] * 3
    assert all(type(pickle.loads(pickle.dumps(error))) is type(error) for error in (*lost, *others))


POOL = """
import sys
sys.path.insert(0, {here!r})
from cases import processes, sweep
from test_workers import server_of_this_process

if __name__ == "__main__":
    with processes(1) as one, processes(1) as other:
        for pool in (one, other):
            sweep(executor=pool)
            print(*pool._processes, pool.submit(server_id).result(), flush=True)
        sys.stdin.read()
"""


def server_id():
    return server_of_this_process().pid


def test_the_workers_of_a_client_that_was_killed_end_with_their_servers():
    program = subprocess.Popen([sys.executable, "-c", POOL.format(here=str(Path(__file__).parent)).replace(
        "server_of_this_process", "server_id")], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
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
    assert worker.share_of(dataclasses.replace(task, threads=0)) == Share(0)
    assert worker.share_of(dataclasses.replace(task, threads=2)).memory == pytest.approx(0.75 / 4 * machine, rel=0.02)
    monkeypatch.setenv("SLURM_CPUS_PER_TASK", "4")
    assert worker.share_of(task) == (4, pytest.approx(0.75 / 2 * machine, rel=0.02))
