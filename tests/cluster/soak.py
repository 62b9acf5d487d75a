"""The bodies of a sweep on a cluster: its cost on two workers, and its bytes on one, two and four while one is killed every
few seconds.

    soak.py dask|ray|processes [--bodies N] [--kill-every SECONDS]

Prints processor times and hashes; fails where a hash differs, a point is missing or a bound is exceeded. The cost is the
least of two runs each, in turns, so that what else the machine does counts less.
"""
from __future__ import annotations

import argparse
import os
import signal
import threading
import time
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from typing import Any, Callable, Iterator

import numpy as np
import psutil

import stiefel
from stiefel._sweep.chunks import Task, Values
from stiefel._sweep.reduction import reduce, request_of

STEPS = 10_000
SCENE = {"system": "rigid_body", "step": 0.01, "method": {"name": "preprocessed_variational", "order": 10},
         "body": {"moments": [1, 2, 3], "angular_velocity": [0, 1, 0]}}
SUMMARIZE = {"quaternion": ["last"], "energy": ["drift"]}
Make = Callable[[int], Any]  # a cluster of so many workers
SERVERS_BOUND = 1.03  # of the servers' processor time against one ensemble in one process
EVERYTHING_BOUND = {"dask": 1.10, "ray": 1.20, "processes": 1.10}
MEMORY_BOUND = 300e6  # bytes of this process


def axes(bodies: int) -> dict[str, Any]:
    rng = np.random.default_rng(18)
    moments = 1 + rng.random(size=(bodies, 3))  # the sum of any two exceeds the third
    return {"body.moments": moments, "body.angular_velocity": rng.normal(size=(bodies, 3))}


@contextmanager
def dask(workers: int) -> Iterator[Any]:
    import dask
    from distributed import Client, LocalCluster

    # A worker that is killed again and again is not there 15 s after its death, and the cluster would give its place up.
    dask.config.set({"distributed.deploy.lost-worker-timeout": "1 hour"})
    with LocalCluster(n_workers=workers, threads_per_worker=1, processes=True, dashboard_address=None) as cluster, \
            Client(cluster) as client:
        yield client.get_executor()


@contextmanager
def ray(workers: int) -> Iterator[Any]:
    import ray

    os.environ["RAY_AUTH_MODE"] = "disabled"
    ray.init(num_cpus=workers, include_dashboard=False, log_to_driver=False)
    try:
        yield stiefel.ray.Executor()
    finally:
        ray.shutdown()


@contextmanager
def processes(workers: int) -> Iterator[Any]:
    with ProcessPoolExecutor(workers) as pool:
        yield pool


def is_server(process: psutil.Process) -> bool:
    return "stiefel-server" in process.name()


def is_worker(process: psutil.Process) -> bool:
    """A process that has started a server. Its own processes are no others of the cluster."""
    return any(is_server(child) for child in process.children())


def descendants() -> list[psutil.Process]:
    """Of this process. Ray's daemons are its children, too."""
    return psutil.Process().children(recursive=True)


class Usage:
    """Seconds of user and system time, of servers and of all, this process included, and the memory of this process;
    sampled, so that processes that end are counted up to their last sample. The sampling itself does not count."""

    def __init__(self) -> None:
        self._seen: dict[tuple[int, float], tuple[bool, float, float]] = {}
        self._own = 0.0
        self.peak = 0  #: the most bytes that this process had
        self.wall = 0.0  #: seconds that passed
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)

    def sample(self, first: bool = False) -> None:
        self.peak = max(self.peak, psutil.Process().memory_info().rss)
        for process in [psutil.Process(), *descendants()]:
            try:
                key, spent = (process.pid, process.create_time()), sum(process.cpu_times()[:2])
                server, begun, _ = self._seen.get(key, (is_server(process), spent if first else 0.0, 0.0))
                self._seen[key] = (server, begun, spent)
            except psutil.Error:
                pass

    def _run(self) -> None:
        while not self._stop.wait(0.2):
            self.sample()
        self._own = time.thread_time()

    def __enter__(self) -> Usage:
        self.sample(first=True)
        self.wall = -time.monotonic()
        self._thread.start()
        return self

    def __exit__(self, *exception: object) -> None:
        self.wall += time.monotonic()
        self._stop.set()
        self._thread.join()
        self.sample()

    @property
    def servers(self) -> float:
        return sum(end - begun for server, begun, end in self._seen.values() if server)

    @property
    def everything(self) -> float:
        return sum(end - begun for _, begun, end in self._seen.values()) - self._own


@contextmanager
def killing(every: float) -> Iterator[list[int]]:
    """Kills a worker every so many seconds."""
    killed: list[int] = []
    stop = threading.Event()

    def run() -> None:
        while not stop.wait(every):
            workers = [process for process in descendants() if process.is_running() and is_worker(process)]
            if workers:
                worker = workers[len(killed) % len(workers)]
                try:
                    worker.send_signal(signal.SIGKILL)
                    killed.append(worker.pid)
                except psutil.Error:
                    pass

    thread = threading.Thread(target=run, daemon=True)
    thread.start()
    yield killed
    stop.set()
    thread.join()


def one_ensemble(bodies: int) -> Usage:
    """What a server, and it and this process, use to compute the bodies as one ensemble; of more bodies than an ensemble may
    have, as few ensembles as possible."""
    values = axes(bodies)
    largest = 1 << 16
    request = request_of(STEPS, 0, 1, SUMMARIZE)
    with stiefel.Server.start() as server, stiefel.Client(server.address, timeout=None) as client, Usage() as spent:
        base = stiefel.to_message(SCENE)
        for name in ("moments", "angular_velocity"):
            base.body.ClearField(name)
        for begin in range(0, bodies, largest):
            part = {path: numbers[begin:begin + largest] for path, numbers in values.items()}
            task = Task(base.SerializeToString(), len(next(iter(part.values()))),
                        tuple(Values(path, None, numbers) for path, numbers in part.items()), b"", "")
            reduce(client, task.ensemble(), request, "", None)
    return spent


def on_workers(bodies: int, make: Make, workers: int) -> tuple[Usage, Any]:
    """What a sweep on workers that are up uses, and its result."""
    with make(workers) as executor:
        stiefel.sweep(SCENE, {"step": [0.01, 0.02, 0.03, 0.04]}, to=1, summarize=SUMMARIZE, executor=executor)
        with Usage() as spent:
            result = sweep(bodies, executor)
    return spent, result


def sweep(bodies: int, executor: Any) -> Any:
    return stiefel.sweep(SCENE, axes(bodies), to=STEPS, summarize=SUMMARIZE, zipped=True, executor=executor)


def missing(result: Any) -> int:
    """Points that did not reach the last step."""
    return int(((result["outcome"] != 1) | (result["last_step"] != STEPS)).sum())


def cost(bodies: int, make: Make, bounds: Bounds) -> str:
    """The hash of a sweep on two workers that nobody disturbs."""
    alone, spread = [], []
    for _ in range(2):
        alone.append(one_ensemble(bodies))
        print(f"one ensemble of {bodies} bodies: servers {alone[-1].servers:.1f} s, everything {alone[-1].everything:.1f} s",
              flush=True)
        spent, result = on_workers(bodies, make, 2)
        spread.append(spent)
        print(f"2 workers: servers {spent.servers:.1f} s, everything {spent.everything:.1f} s, {result.attrs['chunks']} chunks, "
              f"this process {spent.peak / 1e6:.0f} MB, sha256 {result.attrs['sha256'][:16]}", flush=True)
        bounds.check(f"{missing(result)} points are missing", missing(result) == 0)
        bounds.check(f"this process had {spent.peak / 1e6:.0f} MB, at most {MEMORY_BOUND / 1e6:.0f}", spent.peak < MEMORY_BOUND)
    for what, bound in (("servers", SERVERS_BOUND), ("everything", EVERYTHING_BOUND[make.__name__])):
        ratio = min(getattr(one, what) for one in spread) / min(getattr(one, what) for one in alone)
        bounds.check(f"{what} {ratio:.3f} x that of one ensemble, at most {bound}", ratio <= bound)
    return str(result.attrs["sha256"])


def under_fire(bodies: int, make: Make, workers: int, kill_every: float, bounds: Bounds) -> str:
    """The hash of a sweep of whose workers one is killed every few seconds."""
    begun = time.monotonic()
    with make(workers) as executor, killing(kill_every) as killed, Usage() as spent:
        result = sweep(bodies, executor)
    print(f"{workers} workers, {len(killed)} killed in {time.monotonic() - begun:.0f} s: failures {result.attrs['failures']}, "
          f"this process {spent.peak / 1e6:.0f} MB, sha256 {result.attrs['sha256'][:16]}", flush=True)
    bounds.check(f"{len(killed)} workers were killed, at least 1", len(killed) > 0)
    bounds.check(f"{missing(result)} points are missing", missing(result) == 0)
    return str(result.attrs["sha256"])


class Bounds:
    """What does not hold."""

    def __init__(self) -> None:
        self.exceeded: list[str] = []

    def check(self, what: str, holds: bool) -> None:
        print(f"{'holds' if holds else 'EXCEEDED'}: {what}", flush=True)
        if not holds:
            self.exceeded.append(what)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("cluster", choices=("dask", "ray", "processes"))
    parser.add_argument("--bodies", type=int, default=100_000)
    parser.add_argument("--kill-every", type=float, default=5.0)
    arguments = parser.parse_args()
    make: Make = {"dask": dask, "ray": ray, "processes": processes}[arguments.cluster]
    bounds = Bounds()
    hashes = {cost(arguments.bodies, make, bounds)}
    hashes |= {under_fire(arguments.bodies, make, workers, arguments.kill_every, bounds) for workers in (1, 2, 4)}
    bounds.check(f"{len(hashes)} hashes in all", len(hashes) == 1)
    if bounds.exceeded:
        raise SystemExit("; ".join(bounds.exceeded))


if __name__ == "__main__":
    main()
