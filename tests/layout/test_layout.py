"""No file includes against the order of the folders, and no code asks for the name of a system or a method."""
from __future__ import annotations

import re
import subprocess
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[2]

# The lowest rooms come first. A room may include from itself and from the lines above its own.
ENGINE = [
    ["engine/numbers"],
    ["engine/dense"],
    ["engine/methods"],
    ["engine/scene"],
    ["engine/motion"],
    ["engine/structure", "engine/growth", "engine/accuracy", "engine/summary"],
]
# Each has a family of systems and hands out a SystemEntry for each of them. No other room includes from a wing.
WINGS = ["engine/body", "engine/frame", "engine/bracket"]
# Headers that write numbers and names as text. Every folder may include them, for error messages.
TEXT = {"engine/numbers/to_text.h", "engine/scene/near_name.h"}

ENGINE_FOLDERS = [*(folder for line in ENGINE for folder in line), *WINGS]
PUBLIC, CLIENT = r"stiefel/[a-z_]+\.h", r"stiefel/client/.*"
PROTO = r"stiefel/v1/.*"
# The only folder that sees both messages and the engine.
CONVERSION = "server/convert"
# What the folders outside the engine may include with quotes, in addition to TEXT and themselves.
OTHERS = {
    "engine/include/stiefel": [PUBLIC],
    "server/scheduling": [r"stiefel/(crew|stop)\.h"],
    "server/sessions": [PUBLIC, r"server/scheduling/.*"],
    "server/sessions/store": [r"server/scheduling/(principal|process)\.h", r"server/sessions/.*"],
    CONVERSION: [PUBLIC, PROTO, r"server/(scheduling|sessions)/.*"],
    "server/connections": [r"server/(scheduling|sessions)/.*"],
    "server/calls": [PROTO, r"server/(connections|convert|scheduling|sessions)/.*"],
    "server": [PROTO, r"server/(calls|connections|scheduling|sessions)/.*"],
    "server/program": [r"server/(connections|scheduling)/.*", r"server/server\.h"],
    "client/cpp": [CLIENT, PROTO],
}
# The headers of gRPC and protobuf, and the folders that must not include them.
WIRE = re.compile(r"(grpc|google/protobuf|src/proto/grpc)")
WITHOUT_WIRE = ["engine", "server/scheduling", "server/sessions"]


def sources() -> Iterator[Path]:
    for top in ("engine", "server", "client/cpp"):
        yield from (path.relative_to(ROOT) for path in sorted((ROOT / top).rglob("*")) if path.suffix in (".h", ".cc", ".in", ".inc"))


def folder_of(path: str, folders: list[str]) -> str:
    """The innermost of `folders` that holds the path; an empty name if none does."""
    return max((folder for folder in folders if path.startswith(folder + "/")), key=len, default="")


def may_include(file: str, included: str) -> bool:
    if included in TEXT:
        return True
    if folder := folder_of(file, ENGINE_FOLDERS):
        other = folder_of(included, ENGINE_FOLDERS)
        if other == folder or re.fullmatch(PUBLIC, included):
            return True
        level = {name: k for k, line in enumerate([*ENGINE, WINGS]) for name in line}
        return other != "" and level[other] < level[folder]
    folder, other = folder_of(file, list(OTHERS)), folder_of(included, list(OTHERS))
    inside = other == folder and (folder != "server" or re.fullmatch(r"server/[a-z_]+\.h", included))
    return bool(inside) or any(re.fullmatch(allowed, included) for allowed in OTHERS[folder])


def test_no_arrow_against_the_order():
    files = list(map(str, sources()))
    assert len(files) > 200 and all(folder_of(file, [*ENGINE_FOLDERS, *OTHERS]) for file in files)
    wrong = []
    for file in files:
        for line in re.findall(r'^[ \t]*#\s*include .*', (ROOT / file).read_text(), re.M):
            name = re.split(r'[<>"]', line)[1]
            if not may_include(file, name) if '"' in line else WIRE.match(name) and folder_of(file, WITHOUT_WIRE):
                wrong.append(f"{file}: {line}")
    assert wrong == []


# Where names may stand: in the declaration of the system or method itself, in an entry's recommendations, the continuous
# system of a discrete one and that by which the steps of a view are priced, and in the tables of counts. `exact` is also the name of a conservation.
OWN = re.compile(r'info\.name = |static constexpr const char\* name = |\.name = |\.method = "|entry\.continuous = "|\.priced_as = "|return "exact";')
DATA = {"step_prices.inc", "workspaces.inc"}


def test_no_name_is_asked_for():
    """What the library knows about a system or a method stands in its own file."""
    names = re.findall(r"^SYSTEM\((\w+)\)", (ROOT / "engine/motion/systems.inc").read_text(), re.M)
    names += [name for path in (ROOT / "engine/methods").glob("*.h") for name in re.findall(r'\.name = "(\w+)"', path.read_text())]
    assert len(names) > 20
    names.remove("stiefel")  # also the name of the programs
    quoted = re.compile("|".join(f'"{name}"' for name in names))
    assert [f"{file}: {line}" for file in sources() if file.name not in DATA and file.parts[0] != "client"
            for line in (ROOT / file).read_text().splitlines() if quoted.search(line) and not OWN.search(line)] == []


def test_make_run_configures_no_tests():
    """They need packages that `make run` does not install."""
    def configures(*targets):
        done = subprocess.run(["make", "--dry-run", "--always-make", *targets], cwd=ROOT, capture_output=True, text=True, check=True)
        return [line for line in done.stdout.splitlines() if "cmake --preset" in line]

    run, = configures("run")
    assert "--preset release -DSTIEFEL_TESTS=OFF " in run
    first, then = configures("test")
    assert first == run and "--preset release -DSTIEFEL_TESTS=ON " in then
    assert all("STIEFEL_TESTS" not in line for line in configures("sanitize"))
