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

from stiefel.version import __version__

# What `help(stiefel)` shows.
__all__ = ["Client", "Drive", "SceneLike", "Server", "Session", "__version__", "body_scene", "examples", "load",
           "rerun", "simulate", "solids", "sweep", "to_dict", "to_message"]


def __getattr__(name: str) -> Any:
    """Imports a name of the package when one is first used, because the command `stiefel` needs few of them."""
    if name in __all__ or name[:1].isupper():
        public = importlib.import_module("stiefel._public")
        if name in public.__all__:
            for one in public.__all__:
                globals().setdefault(one, getattr(public, one))
            return globals()[name]
    elif not name.startswith("_"):
        module = "stiefel._sweep.ray" if name == "ray" else f"stiefel.{name}"
        try:
            return importlib.import_module(module)
        except ModuleNotFoundError as error:
            if error.name != module:
                raise
    raise AttributeError(f"module 'stiefel' has no attribute {name!r}")


def __dir__() -> list[str]:
    """Returns the public names without the submodules, for completion."""
    return sorted({"__version__", *importlib.import_module("stiefel._public").__all__})
