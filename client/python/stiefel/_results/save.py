"""Writes a trajectory to a file: .npz, .csv or .json."""
from __future__ import annotations

import io
import json
import math
import os
from contextlib import contextmanager
from typing import Any, Callable, Iterator, TextIO

import numpy as np

from stiefel._results import about, tables

Trajectory = Any  # a `stiefel.Trajectory`


def save(run: Trajectory, file: "str | os.PathLike[str]") -> None:
    """Writes the samples in the format that the extension of the name chooses; `stiefel.load` reads them.

    .npz: `step`, `time` and the fields by name, for `numpy.load`. .csv: one line per sample. .json: the samples by step.
    Each has the resolved scene, the build, the outcome and the estimated error, and `stiefel rerun FILE` computes its
    samples again. Other formats are those of `to_xarray` and `to_dataframe`. Raises ValueError for another extension.
    The file appears under its name only when it is complete.
    """
    write = WRITERS.get(os.path.splitext(os.fspath(file))[1].lower())
    if write is None:
        raise ValueError(f"{os.fspath(file)}: must end in .npz, .csv or .json; `to_xarray` and `to_dataframe` lead to other formats")
    with complete(file) as part:
        write(run, part)


@contextmanager
def complete(file: "str | os.PathLike[str]") -> Iterator[str]:
    """Gives the name under which to write a file, which appears under its own when the block ends well. A pipe or a device
    is written itself."""
    path = os.path.realpath(os.fspath(file))
    if os.path.exists(path) and not (os.path.isfile(path) or os.path.isdir(path)):
        yield path
        return
    part = path + ".part"
    try:
        yield part
        os.replace(part, path)
    except BaseException:
        if os.path.exists(part):
            os.remove(part)
        raise


def _npz(run: Trajectory, part: str) -> None:
    arrays: dict[str, Any] = {"step": run.step, "time": run.time, **run.fields, about.KEY: np.array(about.compact(run).encode())}
    packed = io.BytesIO()  # numpy closes a file badly that could not be written
    np.savez_compressed(packed, **arrays)
    with open(part, "wb") as out:
        out.write(packed.getbuffer())


def _csv(run: Trajectory, part: str) -> None:
    """Writes CSV below two lines with #, which have the description and the units."""
    columns, units = tables.table(run), {"step": "1", "time": run.units["time"], "utc": "UTC"}
    units.update({name: run.units.get(field, "") for field, values in run.fields.items() for name in tables.columns(field, values)})
    if "utc" in columns:
        columns["utc"] = np.datetime_as_string(columns["utc"], timezone="UTC")
    with open(part, "w", encoding="utf-8", newline="\n") as out:
        out.write(f"# {about.compact(run)}\n# units: {','.join(units[name] for name in columns)}\n")
        out.write(",".join(f'"{name}"' if "," in name else name for name in columns) + "\n")
        for row in zip(*(map(str if name in ("step", "utc") else repr, values.tolist()) for name, values in columns.items())):
            out.write(",".join(row) + "\n")


def _json(run: Trajectory, part: str) -> None:
    with open(part, "w", encoding="utf-8", newline="\n") as out:
        write_json(run, out)


def write_json(run: Trajectory, out: TextIO) -> None:
    """Writes {"samples": [...], "format": ..., "scene": ...}. NaN and the infinities, which JSON does not have, become null."""
    out.write('{"samples": [')
    for k, (step, time) in enumerate(zip(run.step.tolist(), finite(run.time))):
        sample = {"step": step, "time": time, "fields": {name: finite(values[k]) for name, values in run.fields.items()}}
        out.write(f"{',' * (k > 0)}\n{json.dumps(sample)}")
    out.write("],\n" + ",\n".join(f"  {json.dumps(name)}: {json.dumps(value)}" for name, value in about.described(run).items()) + "\n}\n")


def in_json(value: Any, indent: str = "") -> str:
    """Returns JSON with a line for each list of numbers."""
    if isinstance(value, dict) and value:
        parts, ends = [f"{json.dumps(name)}: {in_json(one, indent + '  ')}" for name, one in value.items()], "{}"
    elif isinstance(value, list) and value and isinstance(value[0], (dict, list)):
        parts, ends = [in_json(one, indent + "  ") for one in value], "[]"
    else:
        return json.dumps(value)
    separator = ",\n" + indent + "  "
    return f"{ends[0]}\n{indent}  {separator.join(parts)}\n{indent}{ends[1]}"


def finite(value: Any) -> Any:
    """Returns a value for JSON, with None for NaN and the infinities, which JSON does not have; an array as nested lists, a complex one
    as an object of two such lists."""
    if isinstance(value, dict):
        return {name: finite(one) for name, one in value.items()}
    if isinstance(value, (list, tuple)):
        return [finite(one) for one in value]
    if isinstance(value, (np.ndarray, np.generic)) and value.dtype.kind in "fc":
        if np.iscomplexobj(value):
            return {"values": finite(np.real(value)), "imaginary": finite(np.imag(value))}
        return np.where(np.isfinite(value), value, np.array(None)).tolist()
    if isinstance(value, (np.ndarray, np.generic)):
        return value.tolist()
    return None if isinstance(value, float) and not math.isfinite(value) else value


WRITERS: dict[str, Callable[[Trajectory, str], None]] = {".npz": _npz, ".csv": _csv, ".json": _json}
