"""Ray's workers as an executor of concurrent.futures, for `stiefel.sweep`."""
from __future__ import annotations

from concurrent.futures import Executor as _Executor
from concurrent.futures import Future
from typing import Any, Callable, Optional

import ray


class Executor(_Executor):
    """Submits tasks of `num_cpus` cores each to the cluster of `ray.init`, which is called where it was not.

        stiefel.sweep(..., executor=stiefel.ray.Executor())

    retries: how often Ray itself gives a task to another worker when one dies.
    """

    def __init__(self, num_cpus: float = 1, retries: int = 3, address: Optional[str] = None):
        if not ray.is_initialized():
            ray.init(address=address, ignore_reinit_error=True)
        self._num_cpus = num_cpus
        self._remote = ray.remote(num_cpus=num_cpus, max_retries=retries)(_call)
        self._open = True

    @property
    def _max_workers(self) -> int:
        """The tasks that run at once, as the process pools of concurrent.futures name it."""
        return max(int(ray.cluster_resources().get("CPU", 1) / self._num_cpus), 1)

    def submit(self, function: Callable[..., Any], /, *args: Any, **kwargs: Any) -> "Future[Any]":
        if not self._open:
            raise RuntimeError("cannot schedule new futures after shutdown")
        return self._remote.remote(function, args, kwargs).future()  # type: ignore[no-any-return]

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Ray itself goes on."""
        self._open = False


def _call(function: Callable[..., Any], args: Any, kwargs: Any) -> Any:
    return function(*args, **kwargs)
