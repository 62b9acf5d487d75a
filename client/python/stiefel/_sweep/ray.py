"""An executor of concurrent.futures that uses the workers of Ray, for `stiefel.sweep`."""
from __future__ import annotations

import importlib
from concurrent.futures import Executor as _Executor
from concurrent.futures import Future
from typing import Any, Callable, Optional

ray: Any = importlib.import_module("ray")


class Executor(_Executor):
    """Submits tasks, each with `num_cpus` cores, to a Ray cluster. Calls `ray.init` with `address` if nobody did.

        stiefel.sweep(..., executor=stiefel.ray.Executor())
    """

    def __init__(self, num_cpus: float = 1, address: Optional[str] = None):
        if not ray.is_initialized():
            ray.init(address=address, ignore_reinit_error=True)
        self._num_cpus = num_cpus
        self._remote = ray.remote(num_cpus=num_cpus)(_call)

    @property
    def _max_workers(self) -> int:
        """How many tasks run at once. The name is that in the process pools of concurrent.futures."""
        return max(int(ray.cluster_resources().get("CPU", 1) / self._num_cpus), 1)

    def submit(self, function: Callable[..., Any], /, *args: Any, **kwargs: Any) -> "Future[Any]":
        return self._remote.remote(function, *args, **kwargs).future()  # type: ignore[no-any-return]


def _call(function: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Any:
    return function(*args, **kwargs)
