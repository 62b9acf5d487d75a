"""Workers that die, refuse, or are gone: a lost worker costs its chunk, and the bytes stay."""
import itertools
import os
import pickle
import signal
import subprocess
import sys
import time
from concurrent.futures import BrokenExecutor, Executor, Future, ThreadPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path

import pytest
from cases import can_fork, failures, processes, small_chunks, sweep  # noqa: F401

import stiefel
from stiefel._sweep import orphans, own_server, worker
from stiefel._sweep.failures import is_dead_worker

pytestmark = pytest.mark.usefixtures("small_chunks")


class Submitting(ThreadPoolExecutor):
    """Calls `before(count)` before each submission."""

    def __init__(self, before, workers=2):
        super().__init__(workers)
        self.before, self.count = before, 0

    def submit(self, function, *arguments):
        self.count += 1
        return self.before(self.count) or super().submit(function, *arguments)


def failed(error):
    future = Future()
    future.set_exception(error)
    return future


def losing_a_worker(pool):
    """The pool, whose worker is killed by the third task, the first chunk after two questions. Nothing else is submitted
    until the pool knows that it is broken."""
    submit, count = pool.submit, itertools.count(1)

    def submit_or_kill(function, *arguments):
        if next(count) != 3:
            return submit(function, *arguments)
        assert function is worker.compute
        future = submit(signal.raise_signal, signal.SIGKILL)
        wait([future])
        return future
    pool.submit = submit_or_kill
    return pool


def test_a_killed_worker_costs_its_chunk():
    with losing_a_worker(processes(2)) as pool:
        found = sweep(executor=pool)
    assert found.attrs["sha256"] == sweep().attrs["sha256"]
    assert failures(found)["BrokenProcessPool"] >= 1


def test_a_killed_server_costs_its_chunks(monkeypatch):
    expected = sweep()
    killed = []

    def before(count):
        held = worker.own_server()._held
        if count in (4, 14) and held is not None:
            killed.append(held.server.process.pid)
            held.server.process.kill()

    with Submitting(before) as threads:
        found = sweep(executor=threads)
    assert found.attrs["sha256"] == expected.attrs["sha256"]
    assert killed


def test_an_executor_may_be_made_anew_by_the_caller():
    made = []

    def make():
        pool = processes(1)
        made.append(pool if made else losing_a_worker(pool))
        return made[-1]

    found = sweep(executor=make)
    assert found.attrs["sha256"] == sweep().attrs["sha256"] and len(made) == 2


class KilledWorker(Exception):
    """As Dask raises it: the type is known by its name."""


class Remembering(ThreadPoolExecutor):
    """Knows a task by its content, as Dask does: one that failed fails for ever. The first, a question about the scene,
    fails, and so do the fourth and the fifth."""

    def __init__(self):
        super().__init__(2)
        self.given, self.known = 0, set()

    def submit(self, function, *arguments):
        content = pickle.dumps((function, arguments))
        self.given += 1
        if self.given in (1, 4, 5):
            self.known.add(content)
        return failed(KilledWorker()) if content in self.known else super().submit(function, *arguments)


def test_a_task_that_failed_is_another_task_when_it_is_given_again():
    with Remembering() as executor:
        found = sweep(executor=executor)
    assert len(executor.known) == 3 == failures(found)["KilledWorker"]
    assert found.attrs["sha256"] == sweep().attrs["sha256"]


def test_chunks_that_a_scheduler_gave_up_are_given_again():
    with Submitting(lambda count: failed(KilledWorker("task")) if count % 3 == 0 else None) as threads:
        found = sweep(executor=threads)
    assert found.attrs["sha256"] == sweep().attrs["sha256"] and failures(found)["KilledWorker"] >= 5


def test_a_chunk_that_kills_its_worker_is_given_up_and_the_rest_is_kept(monkeypatch):
    others = []

    class Poisoned(ThreadPoolExecutor):
        def submit(self, function, task):
            if getattr(task, "index", None) == 3 and function is worker.compute:
                wait(others[-3:])
                return failed(KilledWorker("task"))
            others.append(super().submit(function, task))
            return others[-1]

    with Poisoned(2) as threads, pytest.raises(stiefel.SweepFailed) as caught:
        sweep(executor=threads)
    error = caught.value
    assert "the chunk of points 12 to 15 failed 16 times, at last with KilledWorker: task" in str(error)
    assert error.failures == {"KilledWorker": 16} and error.chunks == 15 and error.done >= 3
    outcome = error.partial["outcome"].values
    assert (outcome[12:16] == 0).all() and (outcome == 1).sum() == 4 * error.done


def test_a_pool_whose_workers_all_die_is_given_up(tmp_path):
    with processes(1, initializer=os._exit, initargs=(1,)) as pool:
        with pytest.raises(stiefel.SweepFailed, match="takes no tasks: BrokenProcessPool: ") as caught:
            sweep(executor=pool)
    assert caught.value.done == 0 and caught.value.partial is None


def test_an_executor_that_breaks_for_good_leaves_what_is_done():
    class Breaking(Executor):
        """Neither a process pool nor a function that makes one: nothing can be put in its place."""

        def __init__(self):
            self.threads, self.chunks = ThreadPoolExecutor(1), []

        def submit(self, function, *arguments):
            if len(self.chunks) == 6:
                wait(self.chunks[:1])
                raise BrokenExecutor("no more")
            given = self.threads.submit(function, *arguments)
            if function is worker.compute:
                self.chunks.append(given)
            return given

    with pytest.raises(stiefel.SweepFailed, match="the executor takes no more tasks: BrokenExecutor: no more; .* of 15 chunks are done") as caught:
        sweep(executor=Breaking())
    assert caught.value.done == int((caught.value.partial["outcome"] == 1).sum()) // 4 > 0


def test_a_worker_of_another_build_is_refused(monkeypatch):
    monkeypatch.setattr("stiefel._sweep.worker.REFUSAL", 0.01)
    refused = []

    class Mixed(ThreadPoolExecutor):
        """Every second task is of a sweep that began with another build."""

        def submit(self, function, task):
            if function is worker.compute and task.index % 2 and task.index not in refused:
                refused.append(task.index)
                task = pickle.loads(pickle.dumps(task))
                object.__setattr__(task, "numerics_id", "0" * 16)
            return super().submit(function, task)

    with Mixed(2) as threads:
        found = sweep(executor=threads)
    assert found.attrs["sha256"] == sweep().attrs["sha256"]
    assert failures(found) == {"OtherNumerics": 7}


def test_what_a_task_itself_raises_is_raised():
    def before(count):
        return failed(ZeroDivisionError("in the task")) if count == 5 else None

    with Submitting(before) as threads, pytest.raises(ZeroDivisionError, match="in the task"):
        sweep(executor=threads)


@pytest.mark.parametrize("error, dead", [
    (BrokenProcessPool(), True), (stiefel._sweep.failures.LostServer("gone"), True), (ConnectionResetError(), True),
    (KilledWorker(), True), (stiefel.InvalidArgument("scene"), False), (ValueError(), False), (MemoryError(), False),
])
def test_which_errors_are_the_workers(error, dead):
    assert is_dead_worker(error) is dead
    assert type(pickle.loads(pickle.dumps(error))) is type(error)


def test_the_server_of_a_worker_that_was_killed_ends():
    with processes(1) as pool:
        sweep(executor=pool)
        server = pool.submit(_server_of_this_process).result()
        os.kill(next(iter(pool._processes)), signal.SIGKILL)
        end = time.monotonic() + 60
        while _runs(server) and time.monotonic() < end:
            time.sleep(0.05)
    assert not _runs(server)


POOL = """
import sys
sys.path.insert(0, {here!r})
import stiefel._sweep.chunks
from cases import processes, sweep
from test_lost_workers import _server_of_this_process, _watches

if __name__ == "__main__":
    stiefel._sweep.chunks.LARGEST = 2
    pool, watching = processes(2), set()
    while len(watching) < 2:  # a worker that starts late may find no task left
        sweep(executor=pool)
        watching |= {{pid for pid, watches in pool.map(_watches, range(4)) if watches}}
    print(*pool._processes, pool.submit(_server_of_this_process).result(), flush=True)
    sys.stdin.read()
"""


def test_the_workers_of_a_client_that_was_killed_end():
    """By themselves they would wait for ever: each holds the other's pipe open."""
    program = subprocess.Popen([sys.executable, "-c", POOL.format(here=str(Path(__file__).parent))], stdin=subprocess.PIPE,
                               stdout=subprocess.PIPE, text=True)
    left = [int(pid) for pid in program.stdout.readline().split()]
    assert len(left) == 3 and all(map(_runs, left))
    program.kill()
    program.wait()
    end = time.monotonic() + 300
    while any(map(_runs, left)) and time.monotonic() < end:
        time.sleep(0.05)
    assert not any(map(_runs, left)), {name: Path(f"/proc/{pid}/status").read_text() for name, pid in
                                       zip(("a worker", "another", "the server"), left) if _runs(pid)}


def _watches(_):
    time.sleep(0.1)  # so that every worker has a turn
    return os.getpid(), orphans._watched == os.getpid()


def _server_of_this_process():
    return worker.own_server()._held.server.process.pid


def _runs(pid):
    try:
        with open(f"/proc/{pid}/stat") as file:
            return file.read().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


def test_a_forked_child_leaves_the_server_of_its_parent_alone():
    if not can_fork():
        pytest.skip("the installed gRPC cannot fork")
    own = own_server.OwnServer()
    own.use(lambda client: client.describe(), own_server.Share(1))
    server = own._held.server
    child = os.fork()
    if child == 0:
        code = 0 if own._held is None and server.process.stdin.closed else 1
        own.stop()
        os._exit(code)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
    assert own.use(lambda client: client.describe().version, own_server.Share(1)) and own._held.server is server
    own.stop()
    assert server.process.poll() is not None
