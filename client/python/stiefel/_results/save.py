"""Writes a trajectory to a file: .npz, .csv or .json."""
from __future__ import annotations

import io
import json
import os
from contextlib import contextmanager
from typing import Any, Callable, Iterator, TextIO

import numpy as np

from stiefel._results import about
from stiefel._results.base import Array

Trajectory = Any  # a `stiefel.Trajectory`


def save(run: Trajectory, file: "str | os.PathLike[str]") -> None:
    """Writes the format of the file's extension. Raises ValueError if that is none of `WRITERS`."""
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
    described = about.compact({**about.beginning(run), **about.ending(run)})
    arrays: dict[str, Any] = {"step": run.step, "time": run.time, **run.fields, about.KEY: np.array(described.encode())}
    packed = io.BytesIO()  # numpy closes a file badly that could not be written
    np.savez_compressed(packed, **arrays)
    with open(part, "wb") as out:
        out.write(packed.getbuffer())


def _csv(run: Trajectory, part: str) -> None:
    """Writes CSV: lines that begin with # tell scene, units and, at the end, how the run ended."""
    columns = about.table(run)
    units = [about.unit_of(run, field) for field, values in run.fields.items() for _ in about.columns(field, values)]
    if "utc" in columns:
        columns["utc"], units = np.datetime_as_string(columns["utc"], timezone="UTC"), [*units, "UTC"]
    with open(part, "w", encoding="utf-8", newline="\n") as out:
        out.write(f"# {about.compact(about.beginning(run))}\n")
        out.write(f"# units: {','.join(['1', about.unit_of(run, 'time'), *units])}\n")
        out.write(",".join(f'"{name}"' if "," in name else name for name in columns) + "\n")
        for row in zip(*(map(str if name in ("step", "utc") else repr, values.tolist()) for name, values in columns.items())):
            out.write(",".join(row) + "\n")
        out.write(f"# {about.compact(about.ending(run))}\n")


def _json(run: Trajectory, part: str) -> None:
    with open(part, "w", encoding="utf-8", newline="\n") as out:
        write_json(run, out)


def write_json(run: Trajectory, out: TextIO) -> None:
    """Writes {"samples": [...], "outcome": ..., "scene": ...}. NaN and the infinities, which JSON does not have, become
    null."""
    out.write('{"samples": [')
    separator = "\n"
    for k, (step, time) in enumerate(zip(run.step.tolist(), run.time.tolist())):
        blocks = ", ".join(f"{json.dumps(name)}: {_block(values[k])}" for name, values in run.fields.items())
        out.write(f'{separator}{{"step": {step}, "time": {_in_json(time)}, "fields": {{{blocks}}}}}')
        separator = ",\n"
    rest = {**about.ending(run), **about.beginning(run)}
    parts = (f"  {json.dumps(name)}: {json.dumps(value)}" for name, value in rest.items())
    out.write("],\n" + ",\n".join(parts) + "\n}\n")


def _block(values: Array) -> str:
    """Returns one field of one sample as nested lists; a complex one as an object of two such lists."""
    if np.iscomplexobj(values):
        return f'{{"values": {_lists(np.real(values).tolist())}, "imaginary": {_lists(np.imag(values).tolist())}}}'
    return _lists(values.tolist())


def _lists(values: Any) -> str:
    return f"[{', '.join(map(_lists, values))}]" if isinstance(values, list) else _in_json(values)


def _in_json(value: float) -> str:
    return repr(value) if np.isfinite(value) else "null"


WRITERS: dict[str, Callable[[Trajectory, str], None]] = {".npz": _npz, ".csv": _csv, ".json": _json}
