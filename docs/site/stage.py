"""Copies the project's pages and what they link to into the folder that Sphinx reads."""
from __future__ import annotations

import os
import re
import shutil
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
LINK = re.compile(r"(!?)\[((?:[^\[\]]|\[[^\]]*\])*)\]\(([^)\s]+)\)")
PROTO = re.compile(r"^proto/stiefel/v1/(\w+)\.proto$")

INDEX = """# stiefel

{text}

```{{toctree}}
:hidden:
:caption: Begin

docs/start
docs/tutorials/README
docs/gallery
docs/literature
README <README>
```

```{{toctree}}
:hidden:
:caption: Use

docs/conventions
docs/choosing_a_method
docs/accuracy
docs/catalogue
docs/manifolds
docs/tangents
docs/conjugate_points
docs/lyapunov
docs/integrability
docs/summaries
docs/sweeps
docs/glossary
```

```{{toctree}}
:hidden:
:caption: Look up

reference/python/index
reference/commands/index
reference/cpp/index
reference/protocol/index
{rest}
```

```{{toctree}}
:hidden:
:caption: Operate

docs/operations
tests/bench/README
tests/extremes/README
```

```{{toctree}}
:hidden:
:caption: Change

docs/architecture
docs/adding_a_method
docs/adding_a_system
engine/README
docs/decisions/README
CONTRIBUTING
CHANGELOG
docs/references
```
"""
# The pages below a page.
MORE = {"docs/decisions/README.md": "0*", "docs/tutorials/README.md": "[a-z]*", "tests/extremes/README.md": "REPORT"}
MOVED = {Path("docs/README.md"): Path("index.md"), Path("docs/gallery"): Path("docs/gallery.md")}


def pages() -> list[Path]:
    """The pages of the project, relative to its root."""
    folders = ("docs", "docs/decisions", "docs/tutorials", "engine", "tests/bench", "tests/extremes")
    found = [*ROOT.glob("*.md"), *(path for folder in folders for path in (ROOT / folder).glob("*.md"))]
    return sorted(path.relative_to(ROOT) for path in found)


def stage(source: Path) -> None:
    """Writes all pages of the project to `source`, at their own paths, and the first page of the site."""
    known = set(pages())
    for page in known:
        text = (ROOT / page).read_text(encoding="utf-8")
        if str(page) == "docs/README.md":
            rest = [name for name in (str(one.with_suffix("")) for one in sorted(known) if one.parent == Path("docs"))
                    if f"\n{name}\n" not in INDEX and name != "docs/README"]
            text = INDEX.format(text=text.partition("\n")[2].strip(), rest="\n".join(rest))
            page, text = Path("index.md"), re.sub(r"\]\((?!https?:|#)", "](docs/", text)
        if str(page) in MORE:
            text += f"\n```{{toctree}}\n:hidden:\n:glob:\n\n{MORE[str(page)]}\n```\n"
        target = source / page
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(_relinked(text, page, known, source), encoding="utf-8")


def _relinked(text: str, page: Path, known: set[Path], source: Path) -> str:
    """The text with links that lead somewhere in the site. A file that is no page is copied and downloaded; a link to a
    folder becomes its words."""
    def link(found: re.Match[str]) -> str:
        image, words, address = found.groups()
        file, _, anchor = address.partition("#")
        if not file or "://" in address:
            return found[0]
        target = Path(os.path.normpath(page.parent / file))
        if proto := PROTO.match(str(target)):
            return f"[{words}]({os.path.relpath(f'reference/protocol/{proto[1]}.md', page.parent)})"
        target = MOVED.get(target, target.with_suffix(".md") if target.suffix == ".ipynb" else target)
        if target in made:
            return f"[{words}]({os.path.relpath(target, page.parent)})"
        if (ROOT / target).is_dir() or (target.suffix == ".md" and target not in known):
            return words
        if target not in known and (ROOT / target).is_file():
            copy = source / target
            copy.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(ROOT / target, copy)
        return f"{image}[{words}]({os.path.relpath(target, page.parent)}{'#' + anchor if anchor else ''})"

    made = {*MOVED.values(), *(path.relative_to(ROOT).with_suffix(".md") for path in ROOT.glob("docs/tutorials/*.ipynb"))}
    parts = re.split(r"(^```.*?^```$)", text, flags=re.DOTALL | re.MULTILINE)
    return "".join(part if part.startswith("```") else LINK.sub(link, part) for part in parts)
