"""Sweeps: a motion for each value of named paths into a scene, spread over the cores here or the workers of an executor."""
from __future__ import annotations

import json
import warnings
from concurrent.futures import Executor
from typing import Any, Callable, Mapping, Optional, Sequence, Union

from stiefel.client import Client
from stiefel.errors import InvalidArgument, SceneWarning, Violation
from stiefel.scenes import SceneLike
from stiefel.summary import Quantities
from stiefel.sweeps.axes import base_of, read_axes
from stiefel.sweeps.executors import Workers, workers_for
from stiefel.sweeps.failures import Failures, LostServer, OtherNumerics, SweepFailed
from stiefel.sweeps.plan import Plan, make_plan
from stiefel.sweeps.progress import Progress
from stiefel.sweeps.reduction import request_of
from stiefel.sweeps.result import SweepResult, Table
from stiefel.sweeps.run import ask_all, run_chunks
from stiefel.sweeps.shared_store import Written
from stiefel.sweeps.store import open_store
from stiefel.sweeps.worker import here

__all__ = ["LostServer", "OtherNumerics", "SweepFailed", "SweepResult", "sweep"]


def sweep(scene: SceneLike, axes: Mapping[str, Any], to: int, summarize: Quantities, *,
          start: int = 0, every: int = 1, zipped: bool = False,
          executor: Optional[Union[Executor, Callable[[], Executor]]] = None, servers: Optional[Sequence[Union[str, Client]]] = None,
          store: Optional[Any] = None, progress: bool = False, threads: Optional[int] = None) -> Any:
    """The motions of `scene` with every value of `axes`, reduced to statistics where they run.

        stiefel.sweep(scene, {"inertia": bodies, "body.angular_velocity": spins}, to=10_000,
                      summarize={"energy": ["drift"], "quaternion": ["last"]}, executor=client.get_executor())

    axes: values by their paths in the scene: "inertia", "body.moments", "body.angular_velocity" (points, numbers),
        "initial.Q" (points, rows, cols), one number of such a field as "body.angular_velocity[0]" (points), or what all
        members of an ensemble share: "step", "epsilon", "method.order" (points). The result is a grid with a dimension
        for each axis; `zipped`: the axes stand side by side along one dimension, "point".
    summarize: of fields and invariants at the steps start, start + every, ... and `to`: names of statistics (last,
        min, max, mean, rms, sign_changes, drift), quantiles and histograms, as in `Session.summarize`.
    executor: any of concurrent.futures, those of Dask, mpi4py and loky, `stiefel.ray.Executor`, or a function that
        makes one anew when it breaks. None: one server here on all cores; `servers`: running servers by address, or
        clients of them, where they need more than an address.
    store: a Zarr group, by path or as what zarr.open_group takes. Finished chunks in it are not computed again. Workers
        that see the path write their chunks themselves.
    progress: shows motions done and the time left.
    threads: those of each worker's own server. None: what Dask, Ray or Slurm gave the worker, else 1, here all cores.

    Returns an xarray.Dataset, or a `SweepResult` with the same content where xarray is not installed: a variable
    "energy.drift" for each statistic, "outcome" and "last_step" of each motion, the axes as coordinates, and as
    attributes the resolved scene, the build and the SHA-256 of all arrays. The bytes do not depend on the executor,
    the number of workers, or what failed on the way. A scene without a method gets the recommended one, with the
    substeps that the most demanding point needs; with a tolerance each point gets the method that is chosen for it
    alone, and the variable "method" says which of attrs["methods"].

    InvalidArgument before work starts; SweepFailed, with what is done in `partial`, when a chunk failed too often or
    the executor is gone.
    """
    given = read_axes(axes, zipped)
    base = base_of(scene, given)
    request = request_of(_step("to", to), _step("start", start), _step("every", every), summarize)
    workers, failures = workers_for(executor, servers, threads), Failures()
    try:
        plan = make_plan(base, given, request,
                         lambda count, question, take: ask_all(count, question, workers, failures, take), threads, here())
        for text in plan.warnings:
            warnings.warn(text, SceneWarning, stacklevel=2)
        return _as_dataset(_run(plan, workers, failures, store, progress, _described(request, summarize)))
    finally:
        workers.close()


def _run(plan: Plan, workers: Workers, failures: Failures, store: Optional[Any], progress: bool,
         asked: Mapping[str, Any]) -> SweepResult:
    table, kept, done = Table(plan.axes), open_store(store, plan), set()
    for chunk, arrays in kept.finished() if kept else ():
        table.put(plan.points(chunk), arrays)
        done.add(chunk)

    methods, which = plan.methods() if plan.chooses else ([], None)
    chosen = {"methods": json.dumps(methods)} if plan.chooses else {}

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
                       kept.place if kept and workers.elsewhere else lambda chunk: None, take_written)
        except SweepFailed as error:
            raise _completed(error, len(done), len(plan.chunks), result() if done else None, kept is not None) from error.__cause__
    return result()


def _completed(error: SweepFailed, done: int, chunks: int, partial: Optional[SweepResult], kept: bool) -> SweepFailed:
    """The error with what is done."""
    again = "; they are in the store, and the same call goes on from there" if kept and done else ""
    full = SweepFailed(f"{error.message}; {done} of {chunks} chunks are done{again}", done, chunks, error.failures)
    full.partial = _as_dataset(partial) if partial is not None else None
    return full


def _as_dataset(result: SweepResult) -> Any:
    try:
        return result.to_xarray()
    except ImportError:
        return result


def _described(request: Any, summarize: Quantities) -> dict[str, Any]:
    return {"from": getattr(request, "from"), "to": request.to, "every": request.every,
            "summarize": json.dumps({name: wanted for name, wanted in summarize.items()}, default=list)}


def _step(name: str, value: Any) -> int:
    try:
        if int(value) == value and (name != "every" or value > 0) and value >= 0:
            return int(value)
    except (TypeError, ValueError):
        pass
    rule = f"{value!r}: must be a whole number of at least {int(name == 'every')}"
    raise InvalidArgument(f"{name}: {rule}", (Violation(name, rule),))
