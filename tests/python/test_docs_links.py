"""The pages: every link, anchor and path in backticks leads somewhere, and what they repeat agrees with its source."""
import re
import runpy
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
FOLDERS = ("client", "docker", "docs", "engine", "proto", "server", "tests")
FILES = [path for folder in FOLDERS for path in (ROOT / folder).rglob("*") if path.is_file()]
NAMES = {path.name for path in FILES}
PAGES = sorted([ROOT / "README.md", ROOT / "CONTRIBUTING.md", *(path for path in FILES if path.suffix == ".md")])
# Words in backticks that name a file: with a folder, or a source file alone. `engine/systems/NAME.h` stands for any name.
WITH_FOLDER = re.compile(r"`((?:[\w.-]+/)+[\w.-]*\.(?:cc|h|in|inc|py|md|proto|sh|json|txt|png|svg|bib))`")
FOLDER_ALONE = re.compile(rf"`((?:{'|'.join(FOLDERS)})(?:/[\w-]+)+)`")
SOURCE_ALONE = re.compile(r"`([a-z][\w-]*\.(?:cc|h|inc|py|proto|sh))`")


def text(page: Path) -> str:
    return page.read_text(encoding="utf-8")


def prose(page: Path) -> str:
    """The page without its blocks of code."""
    return re.sub(r"^```.*?^```", "", text(page), flags=re.DOTALL | re.MULTILINE)


def anchors(page: Path) -> set[str]:
    """The anchors of a page's headings, as GitHub makes them."""
    headings = re.findall(r"^#+ (.*)$", prose(page), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


def name(page: Path) -> str:
    return str(page.relative_to(ROOT))


@pytest.mark.parametrize("page", [*PAGES, ROOT / "CHANGELOG.md"], ids=name)
def test_every_link_leads_somewhere(page):
    dead = []
    for link in re.findall(r"\]\(([^)\s]+)\)", prose(page)):
        if "://" in link or link.startswith("https:"):
            continue
        file, _, anchor = link.partition("#")
        target = page.parent / file if file else page
        if not target.exists() or (anchor and anchor not in anchors(target)):
            dead.append(link)
    assert dead == []


@pytest.mark.parametrize("page", PAGES, ids=name)  # the changelog names files that are gone
def test_every_path_in_backticks_exists(page):
    written = prose(page)
    roots = (ROOT, page.parent, ROOT / "engine")
    missing = [path for pattern in (WITH_FOLDER, FOLDER_ALONE) for path in pattern.findall(written)
               if not path.startswith("build/") and Path(path).stem != "NAME"
               and not any((root / path).exists() for root in roots)]
    assert missing + [file for file in SOURCE_ALONE.findall(written) if file not in NAMES] == []


def test_the_index_of_the_documentation_has_every_page():
    index = text(ROOT / "docs/README.md")
    assert [path.name for path in (ROOT / "docs").glob("*.md")
            if path.name != "README.md" and f"]({path.name})" not in index] == []


def test_the_picture_of_the_architecture_is_what_its_script_draws():
    script = runpy.run_path(str(ROOT / "docs/architecture_picture.py"))
    assert text(ROOT / "docs/architecture.svg") == script["picture"]()
