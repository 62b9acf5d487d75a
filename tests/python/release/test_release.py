"""What a release consists of agrees: its versions."""
import os
import re
import runpy
import subprocess
from pathlib import Path

import yaml

import stiefel

ROOT = Path(__file__).parents[3]
CITATION = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
DIST = runpy.run_path(str(ROOT / "docker/dist.py"))


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
