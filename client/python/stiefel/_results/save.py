"""Writes a trajectory to a file, in the formats of `stiefel run --output`."""
from __future__ import annotations

import json
import os
from decimal import Decimal
from typing import IO, Any, Callable, Iterable, Iterator

import numpy as np

from stiefel._results.base import Array
from stiefel._results.kinds import as_matrix, kind_of

Trajectory = Any  # a `stiefel.Trajectory`


def save(run: Trajectory, file: "str | os.PathLike[str]") -> None:
    """Writes the format of the file's extension. Raises ValueError if that is none of .npz, .csv, .json."""
    path = os.path.realpath(os.fspath(file))
    write = _WRITERS.get(os.path.splitext(path)[1].lower())
    if write is None:
        raise ValueError(f"{os.fspath(file)}: must end in {', '.join(list(_WRITERS)[:-1])} or {list(_WRITERS)[-1]}")
    part = path + ".part"
    try:
        with open(part, "wb") as out:
            write(run, out)
        os.replace(part, path)
    except BaseException:
        if os.path.exists(part):
            os.remove(part)
        raise


def number(value: float) -> str:
    """Returns the shortest decimal that reads back to the same bits, as std::to_chars and the command `stiefel` write
    it: fixed where that is not longer than scientific, and always with a point or an exponent."""
    text = repr(value)
    if 1e-3 <= abs(value) < 1e5 or value == 0 or not np.isfinite(value):
        return text
    sign, digits, exponent = Decimal(text).normalize().as_tuple()
    assert isinstance(exponent, int)
    mantissa = "".join(map(str, digits))
    power = exponent + len(mantissa) - 1
    minus = "-" if sign else ""
    scientific = f"{minus}{mantissa[0]}{'.' if mantissa[1:] else ''}{mantissa[1:]}e{power:+03d}"
    fixed = f"{value:.0f}" if exponent >= 0 else f"{value:.{-exponent}f}"
    if len(fixed) > len(scientific):
        return scientific
    return fixed if exponent < 0 else fixed + ".0"


def _npz(run: Trajectory, out: IO[bytes]) -> None:
    arrays: dict[str, Any] = {"step": run.step, "time": run.time, **run.fields}
    np.savez_compressed(out, **arrays)


def _csv(run: Trajectory, out: IO[bytes]) -> None:
    """Writes CSV. The format has no place for the run status."""
    names = [name for field, values in run.fields.items() for name in _columns(field, values)]
    out.write((",".join(["step", "time", *names]) + "\n").encode())
    for step, time, fields in _samples(run):
        numbers = [number(value) for values in fields.values() for value in _flat(values)]
        out.write((",".join([str(step), number(time), *numbers]) + "\n").encode())


def _columns(field: str, values: Array) -> Iterator[str]:
    """Yields the columns of a field: 'q_w', 'q[0]', 'epsilon' or '"Q[0,0]"', of a member 'q_w[2]', 'q[2][0]', 'epsilon[2]'
    or '"Q[2][0,0]"'. A complex number has a column for its real and one for its imaginary part."""
    kind = kind_of(field)
    parts = ("Re ", "Im ") if np.iscomplexobj(values) else ("",)
    is_ensemble = values.ndim == kind.axes + 2
    for of_member in [f"[{member}]" for member in range(values.shape[1])] if is_ensemble else [""]:
        for index in np.ndindex(values.shape[values.ndim - kind.axes:]):
            at = f"[{','.join(map(str, index))}]" if index else ""
            name = kind.columns[index[0]] + of_member if kind.columns else field + of_member + at
            yield from (f'"{part}{name}"' if "," in name else part + name for part in parts)


def _json(run: Trajectory, out: IO[bytes]) -> None:
    """Writes {"samples": [...], "outcome": ...} and, for an outcome other than REACHED, its details. NaN and the
    infinities, which JSON does not have, become null."""
    out.write(b'{"samples": [')
    separator = "\n"
    for step, time, fields in _samples(run):
        blocks = ", ".join(f"{json.dumps(name)}: {_block(name, values)}" for name, values in fields.items())
        line = f'{{"step": {step}, "time": {_in_json(time)}, "fields": {{{blocks}}}}}'
        out.write((separator + line).encode())
        separator = ",\n"
    report: dict[str, Any] = {"outcome": run.outcome.value}
    if run.outcome != "REACHED":
        known = {"largest_step": run.run_status.largest_step, "member": run.run_status.member}
        report.update((name, value) for name, value in known.items() if value is not None and np.isfinite(value))
        report["message"] = run.run_status.message
    out.write(("],\n" + json.dumps(report, indent=2)[2:] + "\n").encode())


def _block(name: str, values: Array) -> str:
    """Returns one field of one sample in the JSON form of a Matrix, for ensembles with the number of members."""
    values = as_matrix(name, values)
    members = f'"members": {values.shape[0]}, ' if values.ndim == 3 else ""
    rows, cols = values.shape[-2:]
    parts = {"values": values.real, "imaginary": values.imag} if np.iscomplexobj(values) else {"values": values}
    lists = ", ".join(f'"{name}": [{_join(part)}]' for name, part in parts.items())
    return f'{{{members}"rows": {rows}, "cols": {cols}, {lists}}}'


def _join(values: Array) -> str:
    return ", ".join(map(_in_json, values.ravel().tolist()))


def _in_json(value: float) -> str:
    return number(value) if np.isfinite(value) else "null"


def _samples(run: Trajectory) -> Iterator[tuple[int, float, dict[str, Array]]]:
    for k, (step, time) in enumerate(zip(run.step.tolist(), run.time.tolist())):
        yield step, time, {name: values[k] for name, values in run.fields.items()}


def _flat(values: Array) -> Iterable[float]:
    """Returns the numbers row by row; a complex number as its real and its imaginary part."""
    flat = np.ascontiguousarray(values).ravel()
    numbers: list[float] = (flat.view(np.float64) if np.iscomplexobj(flat) else flat).tolist()
    return numbers


_WRITERS: dict[str, Callable[[Trajectory, IO[bytes]], None]] = {".npz": _npz, ".csv": _csv, ".json": _json}
