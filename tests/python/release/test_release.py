"""What a release consists of agrees: its versions."""
import os
import re
import runpy
import subprocess
from pathlib import Path

import stiefel

ROOT = Path(__file__).parents[3]
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
