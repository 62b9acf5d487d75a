"""The command, run in this process against one server: what golden.txt says that it prints.

Lines of golden.txt: "= FILE TEXT" writes a file; "$ stiefel ..." runs the command, "% stiefel ..." on a terminal, "< FILE" with
that file as stdin; what it prints on stderr stands behind "! ", its status, if not 0, in brackets. "..." stands for anything.
A number matches one that differs by at most 1e-9 of it or by 1e-14, and blanks match any number of blanks.
"""
import io
import json
import math
import os
import re
import shlex
from pathlib import Path

import pytest

import stiefel
from stiefel.cli import main

HERE = Path(__file__).parent
NUMBER = re.compile(r"(?<![\w.])-?\d+\.?\d*(?:e[-+]?\d+)?(?![\w.])")
TEXTS = (HERE / "golden.txt").read_text(encoding="utf-8").splitlines()
FILES = dict(line[2:].split(" ", 1) for line in TEXTS if line.startswith("= "))


def cases():
    found = []
    for line in TEXTS:
        if line.startswith(("$ ", "% ")):
            found.append((line, []))
        elif found and not line.startswith(("= ", "#")):
            found[-1][1].append(line)
    return [(line, "\n".join(printed).rstrip("\n")) for line, printed in found]


class Stream(io.TextIOWrapper):
    def __init__(self, text=b"", terminal=False):
        super().__init__(io.BytesIO(text), encoding="utf-8")
        self._terminal = terminal

    def isatty(self):
        return self._terminal

    def text(self):
        self.flush()
        return self.buffer.getvalue().decode()


@pytest.fixture(scope="session")
def server():
    with stiefel.Server.start() as running:
        yield running


@pytest.fixture
def command(server, tmp_path, monkeypatch):
    """Runs a command line; returns status, stdout and stderr."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "100")
    for name, text in FILES.items():
        (tmp_path / name).write_text(text, encoding="utf-8")

    def run(line, terminal=False):
        words, _, stdin = line.partition(" < ")
        arguments = shlex.split(words)
        given = (tmp_path / stdin).read_bytes() if stdin else b""
        if arguments and arguments[0] in stiefel.cli.options.COMMANDS and "--server" not in arguments:
            arguments += ["--server", server.address]
        streams = {"stdin": Stream(given), "stdout": Stream(terminal=terminal), "stderr": Stream()}
        with monkeypatch.context() as patched:
            for name, stream in streams.items():
                patched.setattr(f"sys.{name}", stream)
            status = main(arguments)
        return status, streams["stdout"].text(), streams["stderr"].text()
    return run


def matches(expected, found):
    """Whether the text is what is expected, with its numbers about the same."""
    expected, found = (re.sub(" +", " ", text) for text in (expected, found))
    pattern = "".join(".*?" if part == "..." else NUMBER.sub(lambda _: "\0", part) for part in re.split(r"(\.\.\.)", expected))
    parts = ["(-?[0-9.]+(?:e[-+]?[0-9]+)?)" if part == "\0" else part if part == ".*?" else re.escape(part)
             for part in re.split(r"(\0|\.\*\?)", pattern)]
    told = re.fullmatch("".join(parts), found, re.DOTALL)
    wanted = [number for part in expected.split("...") for number in NUMBER.findall(part)]
    return told is not None and all(math.isclose(float(one), float(other), rel_tol=1e-9, abs_tol=1e-14)
                                    for one, other in zip(wanted, told.groups()))


@pytest.mark.parametrize("line, printed", cases(), ids=lambda text: text[2:60] if text[:2] in ("$ ", "% ") else "")
def test_it_prints(command, line, printed):
    status, out, err = command(line[len("$ stiefel "):], line.startswith("%"))
    found = out + "".join(f"! {one}\n" for one in err.splitlines()) + (f"[{status}]\n" if status else "")
    if "GOLDEN" in os.environ:
        with open(os.environ["GOLDEN"], "a", encoding="utf-8") as new:
            new.write(f"{line}\n{found}\n")
    assert matches(printed, found.rstrip("\n")), found


@pytest.mark.parametrize("name", stiefel.cli.options.COMMANDS)
def test_each_command_has_a_help(command, name):
    status, out, err = command(f"{name} --help")
    assert (status, err) == (0, "") and out.startswith(f"usage: stiefel {name} ") and "--json" in out
