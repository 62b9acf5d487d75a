"""The names of the package `stiefel`, which takes them from here when one of them is first used."""
from stiefel import errors, results, solids
from stiefel._given.bodies import body_scene
from stiefel._given.examples import examples
from stiefel._given.typed import Body, FieldName, Method, MethodName, Scene, SystemName
from stiefel._results.load import load, rerun
from stiefel._sweep.dispatch import SweepFailed
from stiefel._sweep.sweep import sweep
from stiefel._client import Client, Tls
from stiefel.errors import *  # noqa: F403
from stiefel.results import *  # noqa: F403
from stiefel._scene import SceneLike, to_dict, to_message
from stiefel._server import Server
from stiefel._session import Drive, Session
from stiefel.simulation import simulate

__all__ = ["Body", "Client", "Drive", "FieldName", "Method", "MethodName", "Scene", "SceneLike", "Server", "Session",
           "SweepFailed", "SystemName", "Tls", "body_scene", "examples", "load", "rerun", "simulate", "solids",
           "sweep", "to_dict", "to_message"]
__all__ += errors.__all__
__all__ += results.__all__
