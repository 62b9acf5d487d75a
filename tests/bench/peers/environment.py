"""Makes a virtual environment with the packages of peers.txt, and reports those that are missing.

    /usr/bin/python3 tests/bench/peers/environment.py build/peers     (or: make bench-peers)
"""
from __future__ import annotations

import subprocess
import sys
import venv
from pathlib import Path

PACKAGES = Path(__file__).with_name("peers.txt")


def make(folder: Path) -> list[str]:
    """Installs the packages one by one, so that a missing one does not prevent the others. Returns those missing."""
    python = python_of(folder)
    if not python.exists():
        venv.create(folder, with_pip=True)
    wanted = [line for line in PACKAGES.read_text().splitlines() if line and not line.startswith("#")]
    return [package for package in wanted if not _install(python, package)]


def python_of(folder: Path) -> Path:
    return folder / "bin/python"


def _install(python: Path, package: str) -> bool:
    pip = [str(python), "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--no-input",
           "--only-binary=:all:", "--constraint", str(PACKAGES)]
    return subprocess.run([*pip, package], stdout=subprocess.DEVNULL).returncode == 0


if __name__ == "__main__":
    missing = make(Path(sys.argv[1]).resolve())
    print("Missing: " + ", ".join(missing) if missing else "Every peer is there.")
