"""The order of the folders, which tells from which folders a file may include, their size, and the names of files.

    /usr/bin/python3 tests/layout/layout.py        (prints every line that breaks the order, and what else is wrong)
"""
from __future__ import annotations

import re
import sys
from collections import Counter, defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[2]
TOPS = ("engine", "server", "client", "proto", "tests", "docs", "docker")
LARGEST_FOLDER = 30
MOST_FOLDERS = 2  # with a source of the same name
# Python and pytest want these names in any folder.
SPECIAL = {"__init__", "__main__", "conftest"}

# The lowest folders come first. A folder may include from itself, its subfolders, and the lines above its own.
ENGINE = [
    ["engine/numbers"],
    ["engine/linalg"],
    ["engine/laws"],
    ["engine/methods"],
    # The rooms of the wings have the mathematics of a family of systems.
    ["engine/rigid_body/body"],
    ["engine/rigid_body/j_d"],
    ["engine/rigid_body/symmetric"],
    ["engine/rigid_body/moser_veselov"],
    ["engine/rigid_body/exact"],
    ["engine/rigid_body/maps"],
    ["engine/frames/body"],
    ["engine/frames/passes"],
    ["engine/frames/geodesics"],
    ["engine/scene"],
    ["engine/stepping"],
    ["engine/catalogue"],
    # The tops of the wings have one entry a system.
    ["engine/rigid_body"],
    ["engine/frames", "engine/double_bracket", "engine/parametric"],
    ["engine/run"],
    ["engine/tangent"],
    ["engine/accuracy"],
    ["engine/conversion"],
    ["engine/diagnosis"],
    ["engine/summary"],
]
# None of these may include from another.
TOP = {"engine/accuracy", "engine/conversion", "engine/diagnosis", "engine/summary"}
# Headers that write numbers and names as text. Every folder may include them, for error messages.
TEXT = {"engine/numbers/to_text.h", "engine/scene/near_name.h"}

ENGINE_FOLDERS = [folder for line in ENGINE for folder in line]
PUBLIC, CLIENT = r"stiefel/[a-z_]+\.h", r"stiefel/client/.*"
PROTO = r"stiefel/v1/.*"
# The only folder that sees both messages and the engine.
CONVERSION = "server/convert"
# What the folders outside the engine may include with quotes, in addition to TEXT and themselves.
OTHERS = {
    "engine/include/stiefel": [PUBLIC],
    "server/scheduling": [r"stiefel/crew\.h"],
    "server/sessions": [PUBLIC, r"server/scheduling/.*"],
    "server/sessions/store": [r"server/scheduling/(principal|process)\.h", r"server/sessions/.*"],
    CONVERSION: [PUBLIC, PROTO, r"server/(scheduling|sessions)/.*"],
    "server/connections": [r"server/(scheduling|sessions)/.*"],
    "server/observability": [PROTO, r"server/(scheduling|sessions)/.*"],
    "server/calls": [PROTO, r"server/(connections|convert|observability|scheduling|sessions)/.*"],
    "server": [PROTO, r"server/(calls|connections|observability|scheduling|sessions)/.*"],
    "server/program": [r"server/(connections|observability|scheduling|sessions)/.*", r"server/server\.h"],
    "client/cpp": [CLIENT, PROTO],
}
# The headers of gRPC and protobuf, and the folders that must not include them.
WIRE = re.compile(r"(grpc|google/protobuf|src/proto/grpc)")
WITHOUT_WIRE = ["engine", "server/scheduling", "server/sessions"]


class Line(NamedTuple):
    file: Path
    number: int
    text: str

    def __str__(self) -> str:
        return f"{self.file}:{self.number}: {self.text}"


def sources(root: Path) -> Iterator[Path]:
    for top in ("engine", "server", "client"):
        for path in sorted((root / top).rglob("*")):
            if path.name.endswith((".h", ".cc", ".cc.in", ".inc")):
                yield path.relative_to(root)


def folder_of(path: str, folders: list[str]) -> str | None:
    """Returns the innermost of `folders` that holds the path; None if none does."""
    inside = [folder for folder in folders if path.startswith(folder + "/")]
    return max(inside, key=len, default=None)


def level(folder: str) -> int:
    return next(k for k, line in enumerate(ENGINE) if folder in line)


def engine_may(folder: str, included: str) -> bool:
    if re.fullmatch(PUBLIC, included):
        return True
    other = folder_of(included, ENGINE_FOLDERS)
    if other is None or other == folder:
        return other == folder
    if {folder, other} <= TOP:
        return False
    return level(other) <= level(folder)


def may_include(file: Path, included: str) -> bool:
    path = str(file)
    if included in TEXT:
        return True
    if folder := folder_of(path, ENGINE_FOLDERS):
        return engine_may(folder, included)
    folder = folder_of(path, list(OTHERS))
    return folder is not None and folder_may(folder, included)


def folder_may(folder: str, included: str) -> bool:
    """Whether a folder outside the engine may include a header that is not in TEXT."""
    if folder_of(included, list(OTHERS)) == folder and (folder != "server" or re.fullmatch(r"server/[a-z_]+\.h", included)):
        return True
    return any(re.fullmatch(allowed, included) for allowed in OTHERS[folder])


def arrows_against_the_order(root: Path = ROOT) -> list[Line]:
    wrong = []
    for file in sources(root):
        for number, text in enumerate((root / file).read_text().splitlines(), 1):
            quoted = re.match(r'\s*#\s*include "([^"]+)"', text)
            angled = re.match(r"\s*#\s*include <([^>]+)>", text)
            if quoted and not may_include(file, quoted[1]):
                wrong.append(Line(file, number, text))
            if angled and WIRE.match(angled[1]) and folder_of(str(file), WITHOUT_WIRE):
                wrong.append(Line(file, number, text))
    return wrong


def large_folders(root: Path = ROOT) -> dict[str, int]:
    """Returns the folders of sources with too many files. The corpus of a fuzzer does not count."""
    count: Counter[str] = Counter()
    for top in TOPS:
        for path in (root / top).rglob("*"):
            if path.is_file() and not {"__pycache__", "corpus"} & set(path.parts):
                count[str(path.parent.relative_to(root))] += 1
    return {folder: files for folder, files in count.items() if files > LARGEST_FOLDER}


def repeated_names(root: Path = ROOT) -> dict[str, list[str]]:
    """Returns the names of sources, without extensions, that too many folders have, with these folders."""
    folders: defaultdict[str, set[str]] = defaultdict(set)
    for top in TOPS:
        for path in (root / top).rglob("*"):
            if path.suffix in (".cc", ".h", ".py") and path.stem not in SPECIAL:
                folders[path.stem].add(str(path.parent.relative_to(root)))
    return {name: sorted(having) for name, having in folders.items() if len(having) > MOST_FOLDERS}


if __name__ == "__main__":
    found = [*map(str, arrows_against_the_order()), *(f"{folder}: {n} files" for folder, n in large_folders().items()),
             *(f"{name} in {', '.join(folders)}" for name, folders in repeated_names().items())]
    print("\n".join(found))
    sys.exit(bool(found))
