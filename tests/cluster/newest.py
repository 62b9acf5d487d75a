"""The tests of the Python client with the wheel and the newest packages that PyPI has for it.

    newest.py FOLDER_OF_WHEELS

The packages that come with a system may be years old, such as Debian's protobuf, and those of an installation by pip are
new. pip reads in the wheel which it needs; the client itself and the programs are those of the build tree, which PYTHONPATH
and STIEFEL_SERVER name.
"""
from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path

from environment import environment, wheel_in

TESTS = Path(__file__).resolve().parents[1] / "python"
NEEDED = ("pytest", "psutil", "pyyaml")  # by the tests alone


def main(wheels: Path) -> int:
    with tempfile.TemporaryDirectory(prefix="stiefel-newest.") as folder:
        python = environment(Path(folder) / "there", f"{wheel_in(wheels)}[dask,plot,progress,xarray]", *NEEDED)
        subprocess.run([python, "-m", "pip", "list", "--disable-pip-version-check"])
        return subprocess.run([python, "-m", "pytest", "-q", "-p", "no:cacheprovider", TESTS],
                              env={**os.environ, "MPLCONFIGDIR": folder}).returncode


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
