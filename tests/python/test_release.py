"""What a release consists of agrees: versions, citation, notes, checksums."""
import hashlib
import os
import re
import runpy
import subprocess
from pathlib import Path

import pytest
import yaml

import stiefel

ROOT = Path(__file__).parents[2]
DIST = runpy.run_path(str(ROOT / "docker/dist.py"))
CHANGELOG = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
CITATION = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))


def test_the_version_is_one(client):
    """That of the project, the package, the programs, a server, the citation, the changelog and the image."""
    named = DIST["versions"]()
    server = Path(os.environ["STIEFEL_SERVER"])
    for program in (server, server.with_name("stiefel")):
        if program.exists():
            said = subprocess.run([program, "--version"], capture_output=True, text=True, check=True).stdout
            named[program.name] = re.search(r"\d+\.\d+\.\d+\S*", said)[0]
    named |= {"stiefel.__version__": stiefel.__version__, "Describe": client.describe().version}
    assert len(named) >= 8 and set(named.values()) == {stiefel.__version__}, named


def test_a_version_that_differs_is_found(tmp_path):
    for file in ("CMakeLists.txt", "client/python/pyproject.toml.in", "CITATION.cff", "CHANGELOG.md", "tests/docker/image.sh"):
        (tmp_path / file).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / file).write_text((ROOT / file).read_text(encoding="utf-8"), encoding="utf-8")
    version = stiefel.__version__
    assert set(DIST["versions"](tmp_path).values()) == {version}
    for file, place in (("CITATION.cff", "CITATION.cff"), ("CHANGELOG.md", "CHANGELOG.md"), ("CMakeLists.txt", "the image")):
        text = (tmp_path / file).read_text(encoding="utf-8")
        (tmp_path / file).write_text(text.replace(version, "9.9.9", 1) if file != "CHANGELOG.md"
                                     else text.replace(f"[{version}]", "[9.9.9]", 1), encoding="utf-8")
        assert DIST["versions"](tmp_path)[place] == "9.9.9"
        (tmp_path / file).write_text(text, encoding="utf-8")


def test_the_notes_are_the_section_of_the_version():
    text = "# Changelog\n\n## [Unreleased]\n\n- later\n\n## [1.2.0] - 2030-01-01\n\n- new\n\n## [1.1.0]\n\n- old\n"
    assert DIST["notes"](text, "1.2.0") == "- new\n"
    with pytest.raises(ValueError, match="1.3.0"):
        DIST["notes"](text, "1.3.0")
    assert len(DIST["notes"](CHANGELOG, stiefel.__version__)) > 1000


def test_the_sums_are_those_of_sha256sum(tmp_path):
    for name in ("b", "a"):
        (tmp_path / name).write_text(name)
    text = DIST["sums"](list(tmp_path.iterdir()))
    assert text.splitlines()[0] == f"{hashlib.sha256(b'a').hexdigest()}  a"
    (tmp_path / "SHA256SUMS").write_text(text)
    assert subprocess.run(["sha256sum", "--check", "--quiet", "SHA256SUMS"], cwd=tmp_path).returncode == 0


def test_the_citation_is_complete():
    """The keys that the Citation File Format requires, those that a reference manager reads, and the day of the release
    once there is one."""
    assert CITATION["cff-version"] == "1.2.0" and CITATION["authors"] == [{"name": "The stiefel developers"}]
    assert {"abstract", "keywords", "license", "message", "title", "type", "version", "references"} <= CITATION.keys()
    day = re.search(r"^## \[\d\S*\] - (\S+)", CHANGELOG, re.MULTILINE)[1]
    assert str(CITATION.get("date-released", "unreleased")) == day


def test_the_citation_has_the_papers_of_the_bibliography():
    bib = (ROOT / "docs/references.bib").read_text(encoding="utf-8")
    entries = [dict(re.findall(r"^  (\w+)\s*= \{(.*)\},$", body, re.MULTILINE))
               for body in re.findall(r"^@\w+\{\w+,\n(.*?)^\}", bib, re.DOTALL | re.MULTILINE)]
    cited = CITATION["references"]
    assert len(entries) == len(cited) > 10
    for entry, reference in zip(entries, cited, strict=True):
        assert reference["authors"] and {"type", "title", "journal"} <= reference.keys()
        assert (entry.get("doi"), entry["volume"], entry["year"]) == (reference.get("doi"), str(reference["volume"]), str(reference["year"]))
        pages = [str(reference[key]) for key in ("start", "end") if key in reference]
        assert entry["pages"].split("--") == pages
