"""Sweeps: runs a scene for many values of its fields, on the cores of this machine or the workers of an executor."""
from __future__ import annotations

import json
from concurrent.futures import Executor
from contextlib import suppress
from typing import Any, Callable, Mapping, Optional, Sequence, Union

from stiefel.client import Client
from stiefel.errors import StiefelError, warn_of_scene
from stiefel._given.numbers import refused, step_index
from stiefel.scene import SceneLike
from stiefel._given.summaries import Quantities
from stiefel._given.when import step_of
from stiefel._sweep.axes import base_of, read_axes
from stiefel._sweep.chunk_store import open_store
from stiefel._sweep.dispatch import ask_all, run_chunks
from stiefel._sweep.executors import Workers, workers_for
from stiefel._sweep.failures import Failures, LostServer, OtherNumerics, SweepFailed
from stiefel._sweep.plan import Plan, make_plan
from stiefel._sweep.progress import Progress
from stiefel._sweep.reduction import request_of
from stiefel._sweep.result import SweepResult, Table
from stiefel._sweep.shared_store import Written
from stiefel._sweep.warned import Warned
from stiefel._sweep.worker import here

__all__ = ["LostServer", "OtherNumerics", "SweepFailed", "SweepResult", "sweep"]


def sweep(scene: SceneLike, axes: Mapping[str, Any], to: Optional[int] = None, summarize: Optional[Quantities] = None, *,
          time: Any = None, start: int = 0, every: int = 1, zipped: bool = False,
          executor: Optional[Union[Executor, Callable[[], Executor]]] = None, servers: Optional[Sequence[Union[str, Client]]] = None,
          store: Optional[Any] = None, progress: bool = False, threads: Optional[int] = None) -> Any:
    """Runs `scene` for every value of `axes` and reduces each motion to statistics on the server that runs it.

        stiefel.sweep(scene, {"inertia": bodies, "body.angular_velocity": spins}, to=10_000,
                      summarize={"energy": ["drift"], "quaternion": ["last"]}, executor=client.get_executor())

    axes: arrays of values by their paths in the scene: "inertia", "body.moments", "body.angular_velocity" (points,
        numbers), "initial.Q" (points, rows, cols), one number of such a field as "body.angular_velocity[0]" (points),
        or a field that all members of an ensemble share, such as "step", "tolerance", "method.order" (points), or whole
        methods as in a scene: {"method": ["rk4", {"name": "variational", "order": 4}]}. The result is a grid with a
        dimension for each axis; with `zipped` the axes vary together along one dimension, "point".
    summarize: statistics of fields and invariants at the steps start, start + every, ... and `to`: names of statistics
        (last, min, max, mean, rms, sign_changes, drift), quantiles and histograms, as in `Session.summarize`. With
        "over_members" all motions together have one value, which is combined here in the order of the points; this is
        not possible for last and quantiles.
    time: instead of `to`, the time of a step, where `step` is no axis.
    executor: an executor of concurrent.futures, Dask, mpi4py or loky, a `stiefel.ray.Executor`, or a function that
        returns one and is called again when the executor breaks. None: one server on all cores of this machine.
    servers: running servers to use instead, as addresses or, where an address does not suffice, as clients.
    store: a Zarr group, given as a path or as anything that zarr.open_group takes, in which finished chunks are kept.
        Chunks that it has are not computed again. Workers that see the path write their chunks themselves.
    progress: shows how many motions are done and the time left.
    threads: threads of each worker's own server. None: as many as Dask, Ray or Slurm gave the worker, or else 1; all
        cores without an executor.

    Returns an xarray.Dataset, or a `SweepResult` with the same content if xarray is not installed. It has a variable
    such as "energy.drift" for each statistic, "outcome" and "last_step" of each motion, the axes as coordinates, and as
    attributes the resolved scene, the build and the SHA-256 of all arrays. Its bytes do not depend on the executor, the
    number of workers, or failures on the way. A scene without a method gets the recommended one, with the substeps that
    the most demanding point needs of those that agree in `step` and all other fields that members share. For a scene with
    a tolerance, a method is chosen for each point alone. Then, and where such a field is an axis, the variable "method"
    has the index of each point's method in attrs["methods"].

    Raises InvalidArgument before work starts, and SweepFailed when a chunk failed too often or the executor takes no more
    tasks. A wrong value at some point, which no other point has, is found when its chunk is computed, and then raises
    InvalidArgument with the chunk's points. The exception has the finished part in `partial`.
    """
    given = read_axes(axes, zipped)
    base = base_of(scene, given)
    if summarize is None:
        raise refused("summarize", "must be given")
    if time is not None and "step" in axes:
        raise refused("time", f"{time!r}: must be absent where `step` is an axis: give `to`")
    request = request_of(step_of("to", to, time, base.step, None), step_index("start", start), step_index("every", every, 1), summarize)
    workers, failures = workers_for(executor, servers, threads), Failures()
    try:
        plan = make_plan(base, given, request,
                         lambda count, question, take: ask_all(count, question, workers, failures, take), threads, here())
        for text in plan.warnings:
            warn_of_scene(text)
        warned = Warned(plan.warnings)
        try:
            return _as_dataset(_run(plan, workers, failures, store, progress, _described(request, summarize), warned))
        finally:
            for text in warned.texts():
                warn_of_scene(text)
    finally:
        workers.close()


def _run(plan: Plan, workers: Workers, failures: Failures, store: Optional[Any], progress: bool,
         asked: Mapping[str, Any], warned: Warned) -> SweepResult:
    table, kept, done = Table(plan.axes, plan.request), open_store(store, plan), set()
    for chunk, arrays in kept.finished() if kept else ():
        table.put(plan.points(chunk), arrays)
        done.add(chunk)

    methods, which = plan.methods() if plan.fills_in else ([], None)
    chosen = {"methods": json.dumps(methods)} if plan.fills_in else {}

    def result() -> SweepResult:
        return table.result({"scene": json.dumps(plan.scene), **asked, "numerics_id": plan.numerics_id, "build": plan.build,
                             **chosen, "chunks": len(plan.chunks), "failures": json.dumps(failures.counted)},
                            {} if which is None else {"method": which})

    with Progress(plan.axes.points, sum(len(plan.points(chunk)) for chunk in done), progress) as bar:
        def finish(chunk: int, arrays: Any) -> None:
            table.put(plan.points(chunk), arrays)
            done.add(chunk)
            bar.add(len(plan.points(chunk)))

        def take(chunk: int, arrays: Any) -> None:
            if kept:
                kept.put(chunk, arrays)
            finish(chunk, arrays)

        def take_written(chunk: int, written: Written) -> bool:
            arrays = kept.read(chunk, written) if kept else None
            if arrays is not None:
                finish(chunk, arrays)
            return arrays is not None

        try:
            run_chunks(plan, [k for k in range(len(plan.chunks)) if k not in done], workers, failures, take,
                       kept.place if kept and workers.in_other_processes else lambda chunk: None, take_written, warned)
        except StiefelError as error:
            raise _completed(error, len(done), len(plan.chunks), result() if done else None, kept is not None) from error.__cause__
        except Exception as error:  # an executor's or a task's own
            with suppress(AttributeError):  # an exception that takes no attributes
                error.partial = _as_dataset(result()) if done else None  # type: ignore[attr-defined]
            raise
    return result()


def _completed(error: StiefelError, done: int, chunks: int, partial: Optional[SweepResult], kept: bool) -> StiefelError:
    """Returns the error with the number of finished chunks and the partial result added."""
    again = "; they are in the store, and the same call goes on from there" if kept and done else ""
    message = f"{error.message}; {done} of {chunks} chunks are done{again}"
    if isinstance(error, SweepFailed):
        error.done, error.chunks = done, chunks
    error._say(message)
    error.partial = _as_dataset(partial) if partial is not None else None
    return error


def _as_dataset(result: SweepResult) -> Any:
    try:
        return result.to_xarray()
    except ImportError:
        return result


def _described(request: Any, summarize: Quantities) -> dict[str, Any]:
    return {"from": getattr(request, "from"), "to": request.to, "every": request.every,
            "summarize": json.dumps({name: wanted for name, wanted in summarize.items()}, default=list)}


def __dir__() -> list[str]:
    return sorted(__all__)
