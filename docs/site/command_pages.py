"""Makes a page of each program from what its `--help` prints, of each command of `stiefel` too."""
from __future__ import annotations

import re
import subprocess
from pathlib import Path

from text import fenced


def _help(program: Path, *command: str) -> str:
    return subprocess.run([program, *command, "--help"], check=True, capture_output=True, text=True).stdout


def commands(text: str) -> list[str]:
    """The commands that a help lists."""
    return re.findall(r"^  ([a-z][\w-]*) ", text.partition("Subcommands:")[2], re.MULTILINE)


def page(program: Path) -> str:
    text = _help(program)
    parts = [f"# {program.name}\n", fenced(text)]
    for command in commands(text):
        parts += [f"## {program.name} {command}\n", fenced(_help(program, command))]
    return "\n".join(parts)


def write(programs: list[Path], folder: Path) -> None:
    for program in programs:
        (folder / f"{program.name}.md").write_text(page(program), encoding="utf-8")
    names = "\n".join(program.name for program in programs)
    (folder / "index.md").write_text(f"# Commands\n\nWhat `--help` prints.\n\n```{{toctree}}\n{names}\n```\n", encoding="utf-8")
