"""Reads a page strictly: its elements by a parser that allows no open or unknown end, its data as JSON without NaN."""
from __future__ import annotations

import base64
import json
import re
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np

EXAMPLES = Path(__file__).parents[3] / "client" / "examples" / "scenes"
EMPTY = {"meta", "input", "br", "link", "img"}
LARGEST = 3_000_000  # bytes of a page


class Elements(HTMLParser):
    """Raises ValueError for an end that fits no start, and for an id that two elements have."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.ids: list[str] = []
        self.attributes: list[tuple[str, str, Any]] = []
        self.scripts: list[str] = []
        self.feed(text)
        self.close()
        if self.open:
            raise ValueError(f"not closed: {self.open}")

    def handle_starttag(self, tag: str, attrs: list[tuple[str, Any]]) -> None:
        self.attributes += [(tag, name, value) for name, value in attrs]
        for name, value in attrs:
            if name == "id":
                if value in self.ids:
                    raise ValueError(f"two elements have the id {value}")
                self.ids.append(value)
        if tag not in EMPTY:
            self.open.append(tag)
            if tag == "script":
                self.scripts.append("")

    def handle_endtag(self, tag: str) -> None:
        if not self.open or self.open.pop() != tag:
            raise ValueError(f"</{tag}> ends nothing")

    def handle_data(self, data: str) -> None:
        if self.open and self.open[-1] == "script":
            self.scripts[-1] += data


class Page:
    def __init__(self, path: Path) -> None:
        self.path = path
        self.text = path.read_text(encoding="utf-8")
        self.elements = Elements(self.text)
        assert path.stat().st_size < LARGEST
        block, self.script = self.elements.scripts
        self.data = json.loads(block, parse_constant=_refuse)

    @property
    def template(self) -> str:
        """The page without its data."""
        return re.sub(r'(<script id="data"[^>]*>).*?(</script>)', r"\1@DATA@\2", self.text, count=1, flags=re.S)

    def array(self, *path: str) -> Any:
        """Returns an array of the data: the times, or (samples, rows, cols) of a field."""
        part = self.data["samples"]
        for name in path:
            part = part[name]
        values = np.frombuffer(base64.b64decode(part["data"], validate=True), part["dtype"])
        if "rows" not in part:
            return values
        values = values.reshape(-1, part["rows"], part["cols"], 2 if part["complex"] else 1)
        return values[..., 0] + 1j * values[..., 1] if part["complex"] else values[..., 0]


def _refuse(constant: str) -> None:
    raise ValueError(f"{constant} is not JSON")
