"""Reads trajectories from files, and runs their scenes again."""
from __future__ import annotations

import json
import math
import os
from pathlib import Path
from typing import Any, Callable, Mapping, Optional, cast

import numpy as np
from numpy.typing import NDArray

from stiefel._results import about
from stiefel._results.estimate import EstimatedError
from stiefel._results.origin import Origin
from stiefel._client import Client
from stiefel.results import Trajectory
from stiefel._scene import to_message
from stiefel.simulation import own_client

Read = tuple[NDArray[Any], NDArray[Any], dict[str, NDArray[Any]], Mapping[str, Any]]  # step, time, fields, description


def load(file: "str | os.PathLike[str]") -> Trajectory:
    """Reads a file that `Trajectory.save` or `stiefel run --output` wrote: .npz, .csv or .json.

    The arrays have the bits that were written; in .json NaN stands for the infinities too. Scene, build, outcome and
    estimated error are those of the run. Raises ValueError for a file of something else.
    """
    path = os.fspath(file)
    read = _READERS.get(os.path.splitext(path)[1].lower())
    if read is None:
        raise ValueError(f"{path}: must end in {', '.join(_READERS)}")
    try:
        step, time, fields, described = read(path)
        if described.get("format") != about.FORMAT:
            raise KeyError(f"its format is {described.get('format')!r}")
        status, error = about.run_status(described), described.get("estimated_error")
        return Trajectory(np.asarray(step, np.int64), np.asarray(time, float), fields, status, 0, _origin(described),
                          error and EstimatedError(**error))
    except MemoryError:
        raise
    except Exception as fault:  # of the libraries that read such files, each with its own kinds
        if isinstance(fault, OSError) and fault.filename is not None:
            raise
        raise ValueError(f"{path}: is not a file of a trajectory: {fault}") from fault


def rerun(file: "str | os.PathLike[str]", *, client: Optional[Client] = None) -> Trajectory:
    """Runs the scene of a file again and returns the same samples, with the same bits if the build is the same.

    `client`: that of the server to use; by default the server of `stiefel.simulate`. The result's `build` tells which
    build computed it, and `stiefel.load(file) == stiefel.rerun(file)` compares all samples. Raises ValueError for a file
    that does not hold a scene.
    """
    saved = load(file)
    if saved.origin is None:
        raise ValueError(f"{os.fspath(file)}: does not hold the scene of the trajectory")
    with (client or own_client()).create(cast(Any, saved.scene)) as session:
        again: Trajectory = session.trajectory(**about.asked(saved), estimate_error=saved.estimated_error is not None)
    return again


def _origin(described: Mapping[str, Any]) -> Optional[Origin]:
    if "scene" not in described:
        return None
    scene: Any = dict(described["scene"])
    asked = described.get("run", {})
    epoch = scene.pop("epoch", None)
    times = np.asarray(asked["times"], float) if "times" in asked else None
    return Origin(to_message(cast(Any, scene)), described["numerics_id"], to=asked.get("to"), times=times, epoch=epoch,
                  side=described.get("side", ""))


def _npz(path: str) -> Read:
    with np.load(path) as arrays:
        fields = {name: arrays[name] for name in arrays.files if name not in ("step", "time", about.KEY)}
        return arrays["step"], arrays["time"], fields, json.loads(bytes(arrays[about.KEY].item()))


def _csv(path: str) -> Read:
    with open(path, encoding="utf-8-sig") as lines:
        first, _, _, *rows = lines
    described = json.loads(first[1:])
    dtypes = {name: np.dtype(field["dtype"]) for name, field in described["fields"].items()}
    counts = [math.prod(described["fields"][name]["shape"]) * (1 + (dtype.kind == "c")) for name, dtype in dtypes.items()]
    table = np.loadtxt(rows, delimiter=",", usecols=range(2 + sum(counts)), ndmin=2) if rows else np.empty((0, 2 + sum(counts)))
    parts = np.split(table[:, 2:], np.cumsum(counts[:-1], dtype=int), axis=1)
    fields = {}
    for (name, dtype), part in zip(dtypes.items(), parts):
        numbers = np.ascontiguousarray(part, np.zeros((), dtype).real.dtype)
        fields[name] = numbers.view(dtype).reshape(len(table), *described["fields"][name]["shape"])
    return table[:, 0], table[:, 1], fields, described


def _json(path: str) -> Read:
    described = json.loads(Path(path).read_text(encoding="utf-8-sig"))
    samples = described.pop("samples")
    fields = {name: _field([one["fields"][name] for one in samples]).astype(field["dtype"]).reshape(-1, *field["shape"])
              for name, field in described["fields"].items()}
    step, time = ([one[name] for one in samples] for name in ("step", "time"))
    return np.array(step, np.int64), np.array(time, float), fields, described


def _field(samples: list[Any]) -> NDArray[Any]:
    """Returns the field of samples given as nested lists, a complex one as objects of two such lists. null becomes NaN."""
    if not samples or not isinstance(samples[0], Mapping):
        return np.array(samples, float)
    values = np.array([one["values"] for one in samples], complex)
    values.imag = np.array([one["imaginary"] for one in samples], float)
    return values


_READERS: dict[str, Callable[[str], Read]] = {".npz": _npz, ".csv": _csv, ".json": _json}
