"""Makes a page of each program from what its `--help` prints, of each command of `stiefel` too."""
from __future__ import annotations

import re
import subprocess
from pathlib import Path

from text import fenced


def _help(program: Path, *command: str) -> str:
    return subprocess.run([program, *command, "--help"], check=True, capture_output=True, text=True).stdout


def commands(text: str) -> list[str]:
    """The commands that a help lists, that of CLI11 or of argparse."""
    listed = re.split(r"^(?:Subcommands:|  COMMAND)$", text, maxsplit=1, flags=re.MULTILINE)[1:]
    return re.findall(r"^ {2}(?: {2})?([a-z][\w-]*)(?: |$)", "".join(listed), re.MULTILINE)


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
