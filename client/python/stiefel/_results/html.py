"""Results as tables: of HTML for the last value of a notebook's cell, of text for a terminal."""
from __future__ import annotations

import dataclasses
import datetime
import html
import reprlib
from typing import Any, Sequence

import numpy as np

ROWS = 20  #: the most rows of a table
_LONGEST = 120  #: characters of a cell


class Shown:
    """Base of results that a notebook shows as a table."""

    def __repr__(self) -> str:
        """Returns the outcome and the fields of the dataclass that are not None, arrays by their shapes."""
        known = [f"{name} {brief(value)}" for name, value in Shown._as_table(self)[2] if value is not None and name != "run_status"]
        outcome = getattr(self, "outcome", None)
        return f"<stiefel.{type(self).__name__} {f'{outcome}, ' if outcome else ''}{', '.join(known)}>"

    def _repr_html_(self) -> str:
        caption, head, rows = self._as_table()
        return table(caption, head, rows)

    def _as_table(self) -> "tuple[str, Sequence[str], list[Sequence[Any]]]":
        """Returns a caption, the names of the columns, and the rows; by default the fields of the dataclass."""
        fields = [field.name for field in dataclasses.fields(self) if field.repr]  # type: ignore[arg-type]
        return f"stiefel.{type(self).__name__}", (), [(name, getattr(self, name)) for name in fields]


def table(caption: str, head: Sequence[str], rows: Sequence[Sequence[Any]]) -> str:
    lines = [f"<tr>{''.join(f'<td>{html.escape(brief(cell))}</td>' for cell in row)}</tr>" for row in rows[:ROWS]]
    if len(rows) > ROWS:
        lines.append(f"<tr><td colspan='{len(rows[0])}'>and {len(rows) - ROWS} more</td></tr>")
    first = f"<thead><tr>{''.join(f'<th>{html.escape(name)}</th>' for name in head)}</tr></thead>" if head else ""
    return f"<table><caption>{html.escape(caption)}</caption>{first}<tbody>{''.join(lines)}</tbody></table>"


def text_table(caption: str, head: Sequence[str], rows: Sequence[Sequence[Any]]) -> str:
    """Returns all rows in columns."""
    cells = [list(map(_in_line, row)) for row in ([head] if head else []) + list(rows)]
    widths = [max(map(len, column)) for column in zip(*cells)]
    return "\n".join([caption, *("  " + "  ".join(map(str.ljust, row, widths)).rstrip() for row in cells)])


def _in_line(value: Any) -> str:
    if isinstance(value, np.ndarray) and value.dtype.kind in "fciu" and value.size <= 24:
        return " ".join(np.array2string(value, precision=6, max_line_width=1000).split())
    return value if isinstance(value, str) else brief(value)


def brief(value: Any) -> str:
    """Returns a short text of a value: of a number six digits, of a large array its shape."""
    if isinstance(value, np.ndarray) and value.size > 4:
        return f"{value.dtype} {value.shape}"
    if isinstance(value, (float, np.floating)):
        return f"{value:.6g}"
    as_text = isinstance(value, (str, datetime.datetime)) or type(value).__module__.startswith("stiefel")
    text = str(value) if as_text else reprlib.repr(value)
    return text if len(text) <= _LONGEST else text[:_LONGEST - 1] + "…"
