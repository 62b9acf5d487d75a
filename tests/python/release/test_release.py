"""What a release consists of agrees: versions, citation, archive."""
import os
import re
import runpy
import subprocess
import tarfile
from pathlib import Path

import pytest
import yaml

import stiefel

ROOT = Path(__file__).parents[3]
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


@pytest.mark.skipif(not (ROOT / ".git").exists(), reason="this is no clone but a source archive")
def test_the_source_archive_of_a_commit_has_the_same_bytes(tmp_path):
    for name in ("one.tar.gz", "other.tar.gz"):
        DIST["archive"]("1.2.3", tmp_path / name)
    assert (tmp_path / "one.tar.gz").read_bytes() == (tmp_path / "other.tar.gz").read_bytes()
    with tarfile.open(tmp_path / "one.tar.gz") as archive:
        names = archive.getnames()
    tracked = subprocess.run(["git", "ls-tree", "-r", "--name-only", "HEAD"], cwd=ROOT, capture_output=True, text=True, check=True)
    assert {f"stiefel-1.2.3/{name}" for name in tracked.stdout.splitlines()} <= set(names)


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
