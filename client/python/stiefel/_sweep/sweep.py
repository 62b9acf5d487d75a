"""Sweeps: runs a scene for many values of its fields, on the cores of this machine or the workers of an executor."""
from __future__ import annotations

import json
import os
import re
from collections import Counter
from concurrent.futures import Executor
from contextlib import suppress
from typing import Any, Mapping, Optional, Sequence, Union

from numpy.typing import NDArray

from stiefel import v1 as pb
from stiefel._given.numbers import refused, step_index
from stiefel._given.summaries import Quantities, to_quantities
from stiefel._given.when import step_of
from stiefel._results.extras import imported, progress_bar
from stiefel._sweep.axes import base_of, read_axes
from stiefel._sweep.dispatch import Workers, spread, workers_for
from stiefel._sweep.plan import Asked, Plan, Resolved, Task, make_plan
from stiefel._sweep.result import Store, Table, canonical
from stiefel._sweep.worker import compute, resolve
from stiefel._client import Client
from stiefel.errors import StiefelError, warn_of_scene
from stiefel._scene import SceneLike

# "member 1: TEXT (2 members have a warning like this)", in which both additions may be absent.
_WARNING = re.compile(r"(?:member (\d+): )?(.*?)(?: \(\d+ members have a warning like this\))?", re.DOTALL)


def sweep(scene: SceneLike, *, axes: Mapping[str, Any], to: Optional[int] = None, time: Any = None, summarize: Quantities,
          start: int = 0, every: int = 1, zipped: bool = False, executor: Optional[Executor] = None,
          servers: Optional[Sequence[Union[str, Client]]] = None, store: "Union[str, os.PathLike[str], None]" = None,
          progress: bool = False, threads: Optional[int] = None) -> Any:
    """Runs `scene` for every value of `axes` and reduces each motion to statistics on the server that runs it.

        stiefel.sweep(scene, axes={"inertia": bodies, "body.angular_velocity": spins}, to=10_000,
                      summarize={"energy": ["drift"], "quaternion": ["last"]}, executor=client.get_executor())

    axes: arrays of values by their paths in the scene: "inertia", "body.moments", "body.angular_velocity" (points,
        numbers), "initial.Q" (points, rows, cols), one number of such a field as "body.angular_velocity[0]" (points),
        or a field that all members of an ensemble share, such as "step", "tolerance", "method.order" (points), or whole
        methods as in a scene: {"method": ["rk4", {"name": "variational", "order": 4}]}. The result is a grid with a
        dimension for each axis; with `zipped` the axes vary together along one dimension, "point".
    to, time: the last step, or its time, where `step` is no axis.
    summarize: statistics at the steps start, start + every, ... and the last, as in `Session.summarize`.
    executor: one of concurrent.futures, Dask, mpi4py or loky, or a `stiefel.ray.Executor`. None: one server here.
    servers: running servers to use instead, as addresses or, where an address does not suffice, as clients.
    store: a folder in which finished chunks are kept. Chunks that it has are not computed again.
    progress: shows how many motions are done and the time left.
    threads: those of each worker's own server. None: what Dask, Ray or Slurm gave the worker, else 1; here all cores.

    Returns an xarray.Dataset with a variable such as "energy.drift" for each statistic, "outcome" and "last_step" of each
    motion, and the axes as coordinates. Its bytes, of which attrs["sha256"] is the digest, do not depend on who computes
    them. Points that agree in all fields that members share have one method: where the scene names none, the recommended
    one, with the substeps that the most demanding point needs, or one that meets the tolerance at all of them. If there are
    several, the variable "method" has the index of each point's method in attrs["methods"].

    Raises ImportError without xarray, InvalidArgument, and SweepFailed when a chunk failed too often or the executor takes
    no more tasks. The exception, and the KeyboardInterrupt of Ctrl-C, says how many chunks are done and has the finished
    part in `partial`.
    """
    imported("xarray", "xarray")
    given = read_axes(axes, zipped)
    base = base_of(scene, given)
    if time is not None and "step" in axes:
        raise refused("time", f"{time!r}: must be absent where `step` is an axis: give `to`")
    asked = Asked(step_of("to", to, time, base.step, None), step_index("start", start), step_index("every", every, 1),
                  _statistics(summarize))
    workers, failures = workers_for(executor, servers), Counter[str]()
    template = Task(b"", asked, threads=0 if threads is None and executor is None else threads)

    def ask(plan: Plan) -> list[Resolved]:
        answers: dict[int, Resolved] = {}
        spread(plan, range(len(plan.chunks)), resolve, workers, failures, answers.__setitem__)
        return [answers[k] for k in range(len(plan.chunks))]

    try:
        plan = make_plan(base, given, template, ask)
        return _run(plan, workers, failures, None if store is None else Store(store, plan.identity()), progress)
    finally:
        workers.close()


def _run(plan: Plan, workers: Workers, failures: "Counter[str]", store: Optional[Store], progress: bool) -> Any:
    table, asked, every, warned = Table(plan.axes), plan.template.asked, range(len(plan.chunks)), set()
    done: set[int] = set()
    methods, which = plan.methods()
    differ = len(methods) > 1 and all(axis.path != "method" for axis in plan.axes.axes)
    attrs = {"scene": json.dumps(plan.scene), "from": asked.start, "to": asked.to, "every": asked.every,
             "summarize": json.dumps(asked.summarize), "numerics_id": plan.template.numerics_id, "build": plan.build,
             "methods": json.dumps(methods), "chunks": len(every)}

    def finish(chunk: int, arrays: Mapping[str, NDArray[Any]]) -> None:
        points = plan.points(chunk)
        table.put(points, {**arrays, **({"method": which[points]} if differ else {})})
        done.add(chunk)
        bar.update(len(points))

    def take(chunk: int, reduced: tuple[dict[str, NDArray[Any]], list[str]]) -> None:
        arrays = canonical(reduced[0])
        if store:
            store.put(chunk, arrays)
        finish(chunk, arrays)
        for text in reduced[1]:
            member, said = _WARNING.fullmatch(text).groups()  # type: ignore[union-attr]
            kind = said.rpartition(": ")[2]
            if kind not in warned:
                warned.add(kind)
                warn_of_scene(f"point {plan.points(chunk)[int(member or 0)]}: {said}; others may have a warning like this")

    with progress_bar(plan.axes.points, progress, " motions") as bar:
        for chunk, arrays in store.finished(every) if store else ():
            finish(chunk, arrays)
        try:
            spread(plan, [chunk for chunk in every if chunk not in done], compute, workers, failures, take)
        except (Exception, KeyboardInterrupt) as error:
            said = f"{len(done)} of {len(every)} chunks are done"
            said += "; they are in the store, and the same call goes on from there" if store and done else ""
            if isinstance(error, StiefelError):
                error._say(f"{error.message}; {said}")
            elif isinstance(error, KeyboardInterrupt):
                error.args = (said,)
            with suppress(AttributeError):  # of an exception that takes no attributes
                error.partial = table.dataset(attrs, failures) if done else None  # type: ignore[union-attr]
            raise
    return table.dataset(attrs, failures)


def _statistics(summarize: Quantities) -> dict[str, dict[str, Any]]:
    """Returns the statistics in one form. Raises InvalidArgument if they are malformed."""
    result = {}
    for quantity in to_quantities(summarize):
        names = [pb.Statistic.Name(number)[len("STATISTIC_"):].lower() for number in quantity.statistics]
        more = {name: list(values) for name, values in (("quantiles", quantity.quantiles), ("edges", quantity.edges)) if values}
        if quantity.over_members:
            raise refused(f"summarize[{quantity.name!r}]", "over_members: must be absent: reduce the Dataset, as by `.mean()`")
        if not names and not more:
            raise refused(f"summarize[{quantity.name!r}]", "nothing is asked for: must have a statistic, quantiles or edges")
        result[quantity.name] = {"statistics": names, **more}
    if not result:
        raise refused("summarize", f"{summarize!r}: must be a mapping from fields and invariants to statistics")
    return result
