"""What a command prints: tables on a terminal, JSON elsewhere, and files that appear when they are complete."""
from __future__ import annotations

import argparse
import csv
import dataclasses
import enum
import os
import shutil
import sys
from pathlib import Path
from typing import Any, Callable, Iterator, Sequence

from google.protobuf import json_format
from google.protobuf.message import Message

from stiefel._results.html import text_table
from stiefel._results.save import complete, finite, in_json
from stiefel._results.tables import table
from stiefel.cli.given import BadInput
from stiefel.results import Conservation

_LEFT_OUT = ("checkpoint", "computed_steps", "work")  # what a result has beside its numbers, and does not compare


def plain(value: Any) -> Any:
    """Returns a result for JSON: the fields of its class by name, how the run ended first."""
    if dataclasses.is_dataclass(value):
        fields = {name: getattr(value, name) for field in dataclasses.fields(value) for name in [field.name.lstrip("_")]
                  if field.compare or name not in _LEFT_OUT}
        status = fields.pop("run_status", None)
        return {**plain(status or {}), **plain(fields)}
    if isinstance(value, Message):
        return json_format.MessageToDict(value, preserving_proto_field_name=True)
    if isinstance(value, dict):
        return {name: plain(one) for name, one in value.items() if not (one is None or isinstance(one, str) and not one)}
    if isinstance(value, (list, tuple)):
        return [plain(one) for one in value]
    return value.value if isinstance(value, enum.Enum) else finite(value)


def is_table(given: argparse.Namespace) -> bool:
    return sys.stdout.isatty() and not given.json


def show(given: argparse.Namespace, table: Callable[[], str], value: Any) -> None:
    """Prints a table on a terminal, elsewhere JSON."""
    print(table() if is_table(given) else in_json(plain(value)))


def tell(given: argparse.Namespace, table: Callable[[], str], value: Any) -> None:
    """Writes JSON to the file of --output, or shows the value."""
    if given.output is None:
        return show(given, table, value)
    with complete(given.output) as part:
        Path(part).write_text(in_json(plain(value)) + "\n", encoding="utf-8")


def as_table(result: Any) -> Callable[[], str]:
    """Returns a function that makes a table of a result: how it ended, and its fields or what stands for them."""
    def table() -> str:
        caption, head, rows = result._as_table()
        known = [row for row in rows if head or row[1] is not None and row[0] not in ("run_status", *_LEFT_OUT)]
        return text_table(caption if head else str(result.outcome), head, known)
    return table


def check_output(file: Any, extensions: Sequence[str]) -> None:
    """Raises BadInput for a file that could not be written at the end, before anything runs."""
    if file is None:
        return
    path = os.path.realpath(file)
    if os.path.splitext(file)[1].lower() not in extensions:
        raise BadInput(f"--output: {file}: must end in {', '.join(extensions[:-1])}{' or ' * (len(extensions) > 1)}{extensions[-1]}")
    if os.path.isdir(path):
        raise BadInput(f"--output: {file}: is a folder")
    folder = os.path.dirname(path)
    if not os.path.isdir(folder) or not os.access(folder, os.W_OK):
        raise BadInput(f"--output: cannot write {file}: {'no permission' if os.path.isdir(folder) else 'there is no such folder'}")


def samples(run: Any, most: int = 12) -> str:
    """Returns a table of some samples of a run, the first and the last ones, as wide as the terminal."""
    columns, width, half = table(run), shutil.get_terminal_size().columns, most // 2
    rows: list[Sequence[Any]] = list(zip(*(column.tolist() for column in columns.values())))
    if len(rows) > most:
        rows[half:-half] = [["..."] * len(columns)]
    lines = text_table(f"{len(run)} sample{'s' * (len(run) != 1)}", list(columns), rows).splitlines()
    return "\n".join(line if len(line) <= width else line[:width - 1] + "…" for line in lines)


def points_csv(tradeoff: Any, out: Any) -> None:
    """Writes the points of a trade-off, each on a line, with the columns of `Tradeoff.to_dataframe`."""
    rows = tradeoff._rows()
    table = csv.DictWriter(out, rows[0], lineterminator="\n")
    table.writeheader()
    table.writerows(rows)


def catalogue(found: Any) -> Iterator[str]:
    """Yields the lines of `stiefel describe`."""
    yield f"stiefel {found.version}\nnumerics id: {found.numerics_id}\nbuild: {found.build}"
    yield f"sessions: {'on disk' if found.durable else 'in memory, lost when the server ends'}\n"
    yield text_table("Methods", (), [
        (one.name, f"order {', '.join(map(str, one.orders))}" if one.orders else "exact", "reversible" * one.reversible, one.summary,
         one.source) for one in found.methods])
    for system in found.systems:
        rows = [("block", one.name, one.shape, one.description + " (optional)" * (not one.required)) for one in system.blocks]
        rows += [("field", one.name, one.shape, one.description) for one in system.fields]
        rows += [("invariant", one.name, "", one.formula) for one in system.invariants]
        rows += [("form", one.name, one.blocks, one.formula) for one in system.forms]
        rows += [("keeps", f"{one.method or '(the map)'} {one.where and f'({one.where})'}", "", ", ".join(
            f"{kept.invariant} {Conservation(kept.conservation)}" for kept in one.preserves)) for one in system.methods]
        rows += [("recommended", one.where or "(every scene)", "", ", ".join(
            f"{name} {value}" for name, value in plain(one.method).items())) for one in system.recommended]
        yield text_table(f"\n{system.name}{' (discrete)' * system.discrete}: {system.summary}\n  {system.equations}  ({system.source})", (), rows)
    yield text_table("\nLimits", (), [(field.name, value) for field, value in found.limits.ListFields() if field.message_type is None])
