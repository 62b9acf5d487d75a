"""No file compares with the name of a system or a method: what the library knows about one stands in its own file."""
from __future__ import annotations

import re

from layout import ROOT, sources

SYSTEMS = re.findall(r"^SYSTEM\((\w+)\)", (ROOT / "engine/catalogue/systems.inc").read_text(), re.M)
METHODS = [name for path in (ROOT / "engine/methods").glob("*.h")
           for name in re.findall(r'\.name = "(\w+)"', path.read_text())]
# Where names may stand: in the declaration of the system or method itself, in an entry's recommendations and the
# continuous system of a discrete one, and in the tables of counts.
OWN = re.compile(r'info\.name = |static constexpr const char\* name = |\.name = |\.method = "|entry\.continuous = "')
DATA = {"engine/catalogue/methods/step_weights.inc", "engine/catalogue/methods/workspaces.inc"}
# `exact` is also the name of a conservation.
CONSERVATION = 'return "exact";'


def quoted_names() -> list[str]:
    names = re.compile("|".join(f'"{name}"' for name in [*SYSTEMS, *METHODS]))
    found = []
    for file in sources(ROOT):
        if str(file) in DATA or file.parts[0] == "client":
            continue
        for number, line in enumerate((ROOT / file).read_text().splitlines(), 1):
            if names.search(line) and not OWN.search(line) and line.strip() != CONSERVATION:
                found.append(f"{file}:{number}: {line}")
    return found


def test_no_name_is_asked_for():
    # The name of the programs is also that of a system.
    assert len(SYSTEMS) >= 17 and len(METHODS) >= 10
    found = [line for line in quoted_names() if '"stiefel"' not in line or "system" in line]
    assert found == [], "\n".join(found)
