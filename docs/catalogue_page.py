"""Writes docs/catalogue.md from what a server says of itself.

    PYTHONPATH=build/release/python /usr/bin/python3 docs/catalogue_page.py > docs/catalogue.md
"""
from __future__ import annotations

import stiefel
from stiefel import v1 as pb

HEAD = """# Catalogue

A *system* is a kind of motion: state, equations, invariants. A *method* turns a continuous system into a map from one
step to the next. A discrete system is itself a map. `stiefel describe` prints the same data of a running server.

The column *kept to rounding* is about invariants. It says nothing about the accuracy of the attitude: see
[accuracy.md](accuracy.md). [RB] and [ST] are in [references.md](references.md).
"""

TANGENTS = """
## Tangents

The systems and methods whose steps have a derivative, for `Linearize`, covariances and `LyapunovSpectrum`; `exact` where
N = 3: [tangents](tangents.md).
"""

RECOMMENDED = """
## Recommended methods

A scene with neither a method nor a tolerance gets the first row of its system whose *scenes* include it. The
relative error of attitude and momentum then stays below 1e-8 over 100 rotations; on V(n, N), where motion may be chaotic,
below 1e-8 times the condition of the motion. Steps longer than the bound are divided into substeps.
"""


def row(*cells: str) -> str:
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


def link(file: str) -> str:
    return f"[{file}](../{file})"


def kept(system: pb.SystemInfo) -> str:
    """What each method keeps to rounding, and within bounds."""
    lines = []
    for method in system.methods:
        names = {kind: [p.invariant.replace("_", " ") for p in method.preserves if p.conservation == kind]
                 for kind in (pb.CONSERVATION_EXACT, pb.CONSERVATION_BOUNDED)}
        exact, bounded = names.values()
        what = "all" if len(exact) == len(method.preserves) else ", ".join(exact)
        if bounded:
            what += ("; " if what else "") + "bounded: " + ", ".join(bounded)
        name = f"`{method.method}`" + (f" ({method.where})" if method.where else "")
        lines.append((f"{name}: " if method.method else "") + (what or "nothing"))
    return "<br>".join(lines)


def systems(catalogue: stiefel.Catalogue) -> str:
    lines = [row("system", "equations", "state", "kept to rounding", "file"), row(*["---"] * 5)]
    for system in catalogue.systems:
        state = ", ".join(block.name for block in system.blocks)
        lines.append(row(f"`{system.name}`<br>{system.summary}", f"`{system.equations}`<br>{system.source}", state,
                         kept(system), link(system.file)))
    return "\n".join(lines)


def with_tangents(catalogue: stiefel.Catalogue) -> str:
    lines = [row("system", "methods"), row(*["---"] * 2)]
    for system in catalogue.systems:
        if names := [f"`{on.method}`" if on.method else "its own map" for on in system.methods if on.has_tangent]:
            lines.append(row(f"`{system.name}`", ", ".join(names)))
    return "\n".join(lines)


def told(one: pb.Recommendation) -> str:
    """A recommended method with all that a scene would say of it."""
    order = f" {one.method.order}" if one.method.HasField("order") and not one.method.HasField("tolerance") else ""
    tolerance = f", tolerance {one.method.tolerance:g}" if one.method.HasField("tolerance") else ""
    return f"`{one.method.name}`{order}, {one.method.arithmetic}{tolerance}"


def recommended(catalogue: stiefel.Catalogue) -> str:
    lines = [row("system", "scenes", "method", "largest h‖Ω‖ of a substep"), row(*["---"] * 4)]
    for system in catalogue.systems:
        for one in system.recommended:
            bound = f"{one.largest_h_omega:g}" if one.largest_h_omega else ""
            others = "all others" if len(system.recommended) > 1 else "all"
            lines.append(row(f"`{system.name}`", one.where or others, told(one), bound))
    return "\n".join(lines)


def methods(catalogue: stiefel.Catalogue) -> str:
    lines = [row("method", "order", "reversible", "source", "file"), row(*["---"] * 5)]
    for method in catalogue.methods:
        lines.append(row(f"`{method.name}`<br>{method.summary}", ", ".join(map(str, method.orders)) or "exact",
                         "yes" if method.reversible else "no", method.source, link(method.file)))
    return "\n".join(lines)


def page(catalogue: stiefel.Catalogue) -> str:
    parts = [f"{HEAD}\n## Systems\n\n{systems(catalogue)}\n\n## Methods\n\n{methods(catalogue)}\n"]
    parts += [TANGENTS + f"\n{with_tangents(catalogue)}\n", RECOMMENDED + f"\n{recommended(catalogue)}\n"]
    return "".join(parts)


if __name__ == "__main__":
    with stiefel.Server.start() as server, stiefel.Client(server.address) as client:
        print(page(client.describe()), end="")
