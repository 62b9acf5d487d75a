"""A motion in one call, on a server that the process starts when it first needs one."""
from __future__ import annotations

from typing import Any, Optional

from stiefel._given.typed import Fields
from stiefel._results.origin import Origin
from stiefel._sweep.own_server import OwnServer, Share
from stiefel._client import Client
from stiefel.results import Trajectory
from stiefel._scene import SceneLike

__all__ = ["simulate"]
__dir__ = lambda: sorted(__all__)  # noqa: E731

_own = OwnServer()


def own_client() -> Client:
    """Returns the client of this process's server, which the first call starts."""
    return _own.hold(Share(threads=0)).client


def simulate(scene: SceneLike, *, to: Optional[int] = None, time: Any = None, times: Any = None,
             every: Optional[int] = None, fields: Optional[Fields] = None, normalize: bool = False, progress: bool = False,
             timeout: Optional[float] = None, estimate_error: bool = False) -> Trajectory:
    """Returns the motion of a scene: `stiefel.simulate("toutatis", time=86400)`.

    `scene`: a dict, the name of one of `stiefel.examples`, or the path of a scene file. Give its end as `to`, the last
    step, or as `time` in seconds, or give `times`; by default the end is the scene's horizon. `every`: the steps between
    two samples; by default 1, or in runs of more than 1000 steps what makes about 1000 samples. The other arguments are
    those of `Session.trajectory` and `Client.create`.

    The first call starts a server with all processors of the machine, which ends with the process. A forked child starts
    its own. Thread-safe. Raises FileNotFoundError if there is no server program, and Unavailable if it does not start.
    """
    with own_client().create(scene, normalize=normalize) as session:
        return session.trajectory(to=to, time=time, times=times, every=every, fields=fields,
                                  progress=progress, timeout=timeout, estimate_error=estimate_error)


Origin.elsewhere = staticmethod(lambda scene: own_client().create(scene))
