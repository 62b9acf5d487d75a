"""Simulates free rigid bodies in any dimension and geodesics on Stiefel manifolds, with a stiefel server.

    run = stiefel.simulate("toutatis", time=86400)

`simulate` starts a server of its own on first use. With a server that others use too:

    with stiefel.Client("host:50551") as client, client.create("scene.json") as session:
        run = session.trajectory(to=10_000, every=10)

What calls return is described by `help(stiefel.results)`, what they raise by `help(stiefel.errors)`; all of these names are
names of `stiefel` too, such as `stiefel.Trajectory` and `stiefel.InvalidArgument`.
"""
from __future__ import annotations

import importlib
from typing import Any

from stiefel import errors, results, solids
from stiefel._given.bodies import body, tumbling
from stiefel._given.examples import examples
from stiefel._given.typed import Body as Body, FieldName as FieldName, Method as Method, MethodName as MethodName
from stiefel._given.typed import Scene as Scene, SystemName as SystemName
from stiefel._results.load import load, rerun
from stiefel.client import Client, Tls as Tls
from stiefel.errors import *  # noqa: F403
from stiefel.results import *  # noqa: F403
from stiefel.scene import SceneLike, to_dict, to_message
from stiefel.server import Server
from stiefel.session import Drive, Session
from stiefel.simulation import simulate
from stiefel.sweep import SweepFailed as SweepFailed, SweepResult as SweepResult, sweep
from stiefel.version import __version__

# What `help(stiefel)` shows. To type checkers `X as X` makes a name public too.
__all__ = ["Client", "Drive", "SceneLike", "Server", "Session", "__version__", "body", "examples", "load",
           "rerun", "simulate", "solids", "sweep", "to_dict", "to_message", "tumbling"]
_MORE = ("Body", "FieldName", "Method", "MethodName", "Scene", "SweepFailed", "SweepResult", "SystemName", "Tls")
_LATER = {"aio": "stiefel.aio", "manifold": "stiefel.manifold", "ray": "stiefel._sweep.ray"}


def __getattr__(name: str) -> Any:
    """Imports a module that most programs do not need when it is first used."""
    if name in _LATER:
        return importlib.import_module(_LATER[name])
    raise AttributeError(f"module 'stiefel' has no attribute {name!r}")


def __dir__() -> list[str]:
    """Returns the public names without the submodules, for completion."""
    return sorted({*__all__, *errors.__all__, *results.__all__, *_MORE})
