"""The messages of the wire and the engine's types: only server/convert sees both.

The order of the folders (layout.py) allows no other folder to include headers of both. But a header may bring in
another, so this also looks for the names of the engine's public types and functions.
"""
from __future__ import annotations

import re
from pathlib import Path

from layout import CONVERSION, PROTO, ROOT, TEXT, Line, sources

ENGINE = r"stiefel/[a-z_]+\.h|engine/.*"
INCLUDE = re.compile(r'\s*#\s*include "([^"]+)"')
# In namespace stiefel at the left margin: types; functions, whose names come after the type of the result.
TYPE = re.compile(r"(?:class|struct|enum class|enum|using) (\w+)\b(?!::)")
FUNCTION = re.compile(r"(?!class|struct|enum|using|template|namespace|static_assert)[A-Za-z][\w:<>,&* ]*[ &*>](\w+)\(")


def engine_names() -> set[str]:
    """The names of the public types and functions."""
    names = set()
    for header in (ROOT / "engine/include/stiefel").glob("*.h"):
        for line in header.read_text().splitlines():
            if found := TYPE.match(line) or FUNCTION.match(line):
                names.add(found[1])
    return names


def sees_messages(text: str) -> bool:
    return bool(re.search(r"\bv1::", text)) or any(re.fullmatch(PROTO, one) for one in included(text))


def included(text: str) -> list[str]:
    return [found[1] for line in text.splitlines() if (found := INCLUDE.match(line))]


def without_comments_and_texts(line: str) -> str:
    return re.sub(r'"(?:[^"\\]|\\.)*"|//.*', "", line)


def engine_beside_messages(root: Path = ROOT) -> list[Line]:
    """The lines of the server, outside of the conversion, that see the engine in a file that sees messages."""
    names = re.compile(rf"(?<![\w.>:])(?:stiefel::)?(?:{'|'.join(sorted(engine_names()))})\b")
    found = []
    for file in sources(root):
        text = (root / file).read_text()
        if file.parts[0] != "server" or str(file).startswith(CONVERSION + "/") or not sees_messages(text):
            continue
        for number, line in enumerate(text.splitlines(), 1):
            header = INCLUDE.match(line)
            if header and header[1] not in TEXT and re.fullmatch(ENGINE, header[1]):
                found.append(Line(file, number, line))
            elif names.search(without_comments_and_texts(line)):
                found.append(Line(file, number, line))
    return found
