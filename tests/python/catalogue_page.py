"""Writes docs/catalogue.md from what a server says of itself.

    PYTHONPATH=build/release/python /usr/bin/python3 tests/python/catalogue_page.py > docs/catalogue.md
"""
from __future__ import annotations

import stiefel
from stiefel.v1 import catalogue_pb2, simulation_pb2

HEAD = """# Catalogue

A *system* is a motion. A *method* turns a continuous system into a map from step to step. A discrete system is a map
already. `stiefel describe` prints the same from a running server.

*Kept to rounding* is said of invariants. It says nothing about the accuracy of the attitude: see
[accuracy.md](accuracy.md). [RB] and [ST] are in [references.md](references.md).
"""


def row(*cells: str) -> str:
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


def link(file: str) -> str:
    return f"[{file}](../{file})"


def kept(system: catalogue_pb2.SystemInfo) -> str:
    """What each method keeps to rounding, and within bounds."""
    lines = []
    for method in system.methods:
        names = {kind: [p.invariant.replace("_", " ") for p in method.preserves if p.kept == kind]
                 for kind in (catalogue_pb2.KEPT_EXACT, catalogue_pb2.KEPT_BOUNDED)}
        exact, bounded = names.values()
        what = "all" if len(exact) == len(method.preserves) else ", ".join(exact)
        if bounded:
            what += ("; " if what else "") + "bounded: " + ", ".join(bounded)
        name = f"`{method.method}`" + (f" ({method.where})" if method.where else "")
        lines.append((f"{name}: " if method.method else "") + (what or "nothing"))
    return "<br>".join(lines)


def systems(catalogue: simulation_pb2.DescribeResponse) -> str:
    lines = [row("system", "equations", "state", "kept to rounding", "file"), row(*["---"] * 5)]
    for system in catalogue.systems:
        state = ", ".join(block.name for block in system.blocks)
        lines.append(row(f"`{system.name}`<br>{system.summary}", f"`{system.equations}`<br>{system.source}", state,
                         kept(system), link(system.file)))
    return "\n".join(lines)


def methods(catalogue: simulation_pb2.DescribeResponse) -> str:
    lines = [row("method", "order", "reversible", "source", "file"), row(*["---"] * 5)]
    for method in catalogue.methods:
        lines.append(row(f"`{method.name}`<br>{method.summary}", ", ".join(map(str, method.orders)) or "exact",
                         "yes" if method.reversible else "no", method.source, link(method.file)))
    return "\n".join(lines)


def page(catalogue: simulation_pb2.DescribeResponse) -> str:
    return f"{HEAD}\n## Systems\n\n{systems(catalogue)}\n\n## Methods\n\n{methods(catalogue)}\n"


if __name__ == "__main__":
    with stiefel.Server.start() as server, stiefel.Client(server.address) as client:
        print(page(client.describe()), end="")
