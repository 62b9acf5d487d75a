"""Simulates free rigid bodies in any dimension and geodesics on Stiefel manifolds, with a stiefel server.

    with stiefel.Server.start() as server, stiefel.Client(server.address) as client:
        with client.create("scene.json") as session:
            run = session.trajectory(to=10_000, every=10)
"""
from __future__ import annotations

import importlib
from typing import Any

from stiefel.answers import Choice, Conversion, EstimatedError, Geodesic
from stiefel.arrays import Batch, Outcome, Price, RunStatus, State, Trajectory
from stiefel.client import Client
from stiefel.diagnosis import Conservation, Diagnosis, Domain, Invariant
from stiefel.drive import Drive
from stiefel.errors import (AlreadyExists, BuildChanged, Cancelled, Closed, CorruptReply, DeadlineExceeded, FailedPrecondition,
                            Internal, InvalidArgument, NotFound, NotStarted, ResourceExhausted, SceneWarning, StiefelError,
                            Unauthenticated, Unavailable, Unimplemented, Violation)
from stiefel.scenes import SceneLike, to_dict, to_message
from stiefel.security import Tls
from stiefel.server import Server
from stiefel.session import Session
from stiefel.summary import Events, Summary
from stiefel.sweeps import SweepFailed, SweepResult, sweep
from stiefel.tradeoff import Point, Tradeoff
from stiefel.version import __version__

__all__ = [
    "AlreadyExists", "Batch", "BuildChanged", "Cancelled", "Choice", "Client", "Closed", "Conservation", "Conversion",
    "CorruptReply", "DeadlineExceeded", "Diagnosis", "Domain", "Drive", "EstimatedError", "Events", "FailedPrecondition",
    "Geodesic", "Internal",
    "Invariant", "InvalidArgument", "NotFound", "NotStarted", "Outcome", "Point", "Price", "ResourceExhausted",
    "RunStatus", "SceneLike", "SceneWarning", "Server", "Session", "State", "StiefelError", "Summary", "SweepFailed",
    "SweepResult", "Tls", "Tradeoff", "Trajectory", "Unauthenticated", "Unavailable", "Unimplemented", "Violation",
    "__version__", "sweep", "to_dict", "to_message",
]


def __getattr__(name: str) -> Any:
    """Imports `stiefel.ray` when it is first used, because only it needs Ray."""
    if name == "ray":
        return importlib.import_module("stiefel.ray")
    raise AttributeError(f"module 'stiefel' has no attribute {name!r}")


def __dir__() -> list[str]:
    """Returns the public names without the submodules, for completion."""
    return __all__
