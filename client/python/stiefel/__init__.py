"""Simulates free rigid bodies in any dimension and geodesics on Stiefel manifolds, with a stiefel server.

    run = stiefel.simulate("toutatis", time=86400)

`simulate` starts a server of its own on first use. With a server that others use too:

    with stiefel.Client("host:50551") as client, client.create("scene.json") as session:
        run = session.trajectory(to=10_000, every=10)
"""
from __future__ import annotations

import importlib
from typing import Any

from stiefel import solids
from stiefel._given.bodies import body, tumbling
from stiefel._given.examples import examples
from stiefel._given.typed import Body, FieldName, Method, MethodName, Scene, SystemName
from stiefel.client import Client, Tls
from stiefel.errors import (AlreadyExists, BuildChanged, Cancelled, Closed, CorruptReply, DeadlineExceeded, FailedPrecondition,
                            Internal, InvalidArgument, NotFound, NotStarted, ResourceExhausted, SceneWarning, StiefelError,
                            Unauthenticated, Unavailable, Unimplemented, Violation)
from stiefel.results import (Batch, Choice, Conservation, Conversion, Diagnosis, Domain, Errors, EstimatedError, Events, Export,
                             Geodesic, Invariant, Motion, Outcome, Point, Price, RunStatus, State, Summary, Tradeoff, Trajectory)
from stiefel._results.load import load, rerun
from stiefel.scene import SceneLike, to_dict, to_message
from stiefel.server import Server
from stiefel.session import Drive, Session
from stiefel.simulation import simulate
from stiefel.sweep import SweepFailed, SweepResult, sweep
from stiefel.version import __version__

__all__ = [
    "AlreadyExists", "Batch", "Body", "BuildChanged", "Cancelled", "Choice", "Client", "Closed", "Conservation",
    "Conversion", "CorruptReply", "DeadlineExceeded", "Diagnosis", "Domain", "Drive", "Errors", "EstimatedError", "Events", "Export",
    "FailedPrecondition", "FieldName", "Geodesic", "Internal", "InvalidArgument", "Invariant", "Method", "MethodName",
    "Motion", "NotFound", "NotStarted", "Outcome", "Point", "Price", "ResourceExhausted", "RunStatus", "Scene", "SceneLike",
    "SceneWarning", "Server", "Session", "State", "StiefelError", "Summary", "SweepFailed", "SweepResult", "SystemName",
    "Tls", "Tradeoff", "Trajectory", "Unauthenticated", "Unavailable", "Unimplemented", "Violation", "__version__", "body",
    "examples", "load", "rerun", "simulate", "solids", "sweep", "to_dict", "to_message", "tumbling",
]


def __getattr__(name: str) -> Any:
    """Imports `stiefel.ray` when it is first used, because only it needs Ray."""
    if name == "ray":
        return importlib.import_module("stiefel._sweep.ray")
    raise AttributeError(f"module 'stiefel' has no attribute {name!r}")


def __dir__() -> list[str]:
    """Returns the public names without the submodules, for completion."""
    return __all__
