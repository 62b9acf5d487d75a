"""Simulates free rigid bodies in any dimension and geodesics on Stiefel manifolds, with a stiefel server.

    import stiefel

    run = stiefel.simulate("toutatis", time=86400)
    with stiefel.Client("host:50551") as client, client.create("scene.json") as session:
        state = session.step(to=10_000)

Functions. `simulate` and `sweep` start a server of their own when they need one.

    simulate         the motion of a scene at equal steps or at any times
    sweep            many motions, on processes, a cluster or servers, as an xarray.Dataset
    body_scene       the scene of a body in three dimensions
    to_message       a scene as the message of the protocol
    to_dict          a message as a scene
    load             the samples of a file that Trajectory.save or `stiefel run` wrote
    rerun            the samples of a file, computed again
    examples         scenes by name: "toutatis", "rigid_body", "stiefel", ...
    solids           inertia tensors of homogeneous solids

Classes. Their own help has the rest: help(stiefel.Client).

    Client           a connection: creates and finds sessions, joins frames, converts scenes, measures trade-offs
    Session          one motion on a server: step, stream, trajectory, diagnose, summarize, events, linearize, lyapunov
    Drive            a session stepped in a loop over one stream
    Server           a server program on this machine
    Trajectory       the samples of a motion; help(stiefel.results) has it and all other results

What calls raise is described by help(stiefel.errors). Modules that are imported by name: `stiefel.manifold` has manifolds of
frames, `stiefel.aio` the client for asyncio. All names of `results` and `errors` are names of `stiefel` too.
"""
from __future__ import annotations

import importlib
from typing import Any

from stiefel.version import __version__


def __getattr__(name: str) -> Any:
    """Imports a name of the package when one is first used, because the command `stiefel` needs few of them."""
    if name.startswith("_"):
        raise AttributeError(f"module 'stiefel' has no attribute {name!r}")
    if name.islower():
        module = "stiefel._sweep.ray" if name == "ray" else f"stiefel.{name}"
        try:
            return importlib.import_module(module)
        except ModuleNotFoundError as error:
            if error.name != module:
                raise
    public = importlib.import_module("stiefel._public")
    if name not in public.__all__:
        raise AttributeError(f"module 'stiefel' has no attribute {name!r}")
    for one in public.__all__:
        globals().setdefault(one, getattr(public, one))
    return globals()[name]


def __dir__() -> list[str]:
    """Returns the public names without the submodules, for completion."""
    return sorted({"__version__", *importlib.import_module("stiefel._public").__all__})
