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
from stiefel.errors import (AlreadyExists as AlreadyExists, BuildChanged as BuildChanged, Cancelled as Cancelled,
                            Closed as Closed, CorruptReply as CorruptReply, DeadlineExceeded as DeadlineExceeded,
                            FailedPrecondition as FailedPrecondition, Internal as Internal,
                            InvalidArgument as InvalidArgument, NotFound as NotFound, NotStarted as NotStarted,
                            ResourceExhausted as ResourceExhausted, SceneWarning as SceneWarning,
                            StiefelError as StiefelError, Unauthenticated as Unauthenticated,
                            Unavailable as Unavailable, Unimplemented as Unimplemented, Violation as Violation)
from stiefel.results import (Batch as Batch, Catalogue as Catalogue, Choice as Choice,
                             ConjugatePoint as ConjugatePoint, ConjugatePoints as ConjugatePoints, Conservation as Conservation,
                             Conversion as Conversion, Diagnosis as Diagnosis, Domain as Domain, Errors as Errors,
                             EstimatedError as EstimatedError, Events as Events, Export as Export,
                             Geodesic as Geodesic, InjectivityRadius as InjectivityRadius, Invariant as Invariant,
                             LyapunovSpectrum as LyapunovSpectrum, Motion as Motion, Origin as Origin,
                             Outcome as Outcome, Point as Point, Price as Price, RunStatus as RunStatus,
                             Section as Section, State as State, StateTransition as StateTransition, Summary as Summary,
                             Tradeoff as Tradeoff, Trajectory as Trajectory, Verdict as Verdict)
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
