"""What the README says is what happens."""
import json
import math
import os
import re
import runpy
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

import scene_types
import stiefel
from stiefel._server import find_server
from stiefel.cli.options import COMMANDS, parse

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")


def block(language):
    return re.search(rf"```{language}\n(.*?)```", README, re.DOTALL)[1]


def test_the_program_prints_what_is_shown(tmp_path):
    """From an empty folder."""
    program = block("python")
    assert len(program.splitlines()) == 11
    result = subprocess.run([sys.executable, "-c", program], cwd=tmp_path, capture_output=True, text=True)
    assert result.returncode == 0, result.stderr
    assert result.stdout == block("text") and result.stderr == ""


PROGRAMS = {f"{page.stem}-{k}": program for page in sorted((ROOT / "docs").glob("*.md"))
            for k, program in enumerate(re.findall(r"```python\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL))
            if "dask_jobqueue" not in program}  # which needs a cluster


@pytest.mark.parametrize("name", PROGRAMS)
def test_a_program_of_a_page_runs(name, tmp_path):
    """From an empty folder, without a warning."""
    assert len(PROGRAMS) >= 9
    done = subprocess.run([sys.executable, "-W", "error:::stiefel", "-c", PROGRAMS[name]], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0 and done.stderr == "", done.stderr
    assert done.stdout.strip(), "it prints what it found"


def test_the_programs_of_the_readme_run(tmp_path):
    for program in re.findall(r"```python\n(.*?)```", README, re.DOTALL):
        result = subprocess.run([sys.executable, "-c", program], cwd=tmp_path, capture_output=True, text=True)
        assert result.returncode == 0 and result.stderr == "", result.stderr


def test_how_long_torque_free_holds():
    """The figures of the README and of the page of conventions follow from the formulas beside them."""
    page = (ROOT / "docs/conventions.md").read_text(encoding="utf-8")
    degree, ratio = math.radians(1), 0.5

    def at_rest(n):
        return math.sqrt(2 * degree / (0.5 * 3 * n**2 * ratio))

    def spinning(n, omega):
        return degree / (1.5 * n**2 * ratio / omega)

    low, sun = math.sqrt(3.986e14 / 6.778e6**3), 2 * math.pi / (365.25 * 86400)
    for n, shown, rest, spin in (
            (low, "1.1e-3 rad/s", f"{at_rest(low) / 60:.0f} min", f"{spinning(low, 0.1) / 60:.0f} min at ω = 0.1 rad/s"),
            (sun, "2.0e-7 rad/s", f"{at_rest(sun) / 86400:.0f} days",
             f"{spinning(sun, 2 * math.pi / 21600) / (365.25 * 86400):.0f} years at one turn in 6 h")):
        row, = [line for line in page.splitlines() if line.startswith("| ") and shown in line]
        assert f"{n:.1e}".replace("e-0", "e-") in shown and rest in row and spin in row, (row, rest, spin)
    drag = 0.5 * 2.8e-12 * 7.7e3**2 * 2.2
    assert f"{drag:.1e}".replace("e-0", "e-") in page and f"{drag * 0.1 / 100:.1e}".replace("e-0", "e-") in page
    gradient = 1.5 * low**2 * ratio
    assert f"{gradient:.1e}".replace("e-0", "e-") in page and 0.15 < drag * 1e-3 / gradient < 0.25
    assert "1° in 3 minutes" in " ".join(README.split()) and "1° in 5 years" in " ".join(README.split())


def test_the_lines_that_start_a_container_agree():
    """Those of this page and of the page of operations; the variables are the server's."""
    lines = {re.findall(r"^docker run .*$", page, re.MULTILINE)[0]
             for page in (README, (ROOT / "docs/operations.md").read_text(encoding="utf-8"))}
    line, = lines
    flags = (ROOT / "docs/operations.md").read_text(encoding="utf-8")
    assert "-p 127.0.0.1:50551:50551" in line
    assert all(f"`{variable}`" in flags for variable in re.findall(r"-e (\w+)=", line))


def test_the_types_of_scenes_are_those_of_the_protocol_and_the_catalogue(client):
    held = ROOT / "client/python/stiefel/_given/typed.py"
    assert scene_types.text(client.describe()) == held.read_text(encoding="utf-8"), "see tests/python/scene_types.py"


def test_the_catalogue_page_is_what_the_server_says(client):
    assert runpy.run_path(str(ROOT / "docs/catalogue_page.py"))["page"](client.describe()) == (ROOT / "docs/catalogue.md").read_text(encoding="utf-8")


def test_the_one_line_for_the_wheel_runs(tmp_path):
    program, = re.findall(r"^python3 -c '(.*)'$", README, re.MULTILINE)
    done = subprocess.run([sys.executable, "-c", program], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0 and done.stderr == "" and done.stdout.startswith("<stiefel.Trajectory REACHED"), done.stderr


PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md")), ROOT / "docker/compose.yaml"]
LINES = [(page.name, line) for page in PAGES
         for line in re.findall(rf"^(?:#   )?(stiefel (?:{'|'.join(COMMANDS)})\b.*)$", page.read_text(encoding="utf-8"), re.MULTILINE)]


@pytest.mark.parametrize("page, line", LINES)
def test_a_command_line_of_a_page_is_right(page, line):
    assert parse(shlex.split(line, comments=True)[1:]).command in line


def test_the_commands_of_the_page_of_operations(tmp_path):
    """A server with TLS and a token, and its client, as printed."""
    page = (ROOT / "docs/operations.md").read_text(encoding="utf-8")
    started, asked = re.search(r"^### Certificates\n.*?```sh\n(.*?)```.*?```sh\n(.*?)```", page, re.DOTALL | re.MULTILINE).groups()
    programs = Path(find_server()).parent
    if not (programs / "stiefel").exists():
        pytest.skip("the command is not built")
    environment = {**os.environ, "PATH": f"{programs}:{os.environ['PATH']}"}
    *made, start = started.strip().rsplit("\n", 1)
    assert subprocess.run(["sh", "-ec", *made], cwd=tmp_path, env=environment, capture_output=True, timeout=120).returncode == 0
    start = start.replace("127.0.0.1:50551", "127.0.0.1:0") + " --exit-with-parent"
    with subprocess.Popen(["sh", "-ec", f"exec {start}"], cwd=tmp_path, env=environment, stdin=subprocess.PIPE,
                          stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as server:
        port = server.stdout.readline().strip().rpartition(":")[2]
        done = subprocess.run(["sh", "-ec", asked.replace("50551", port)], cwd=tmp_path, env=environment, capture_output=True,
                              text=True, timeout=120)
        server.stdin.close()
    assert done.returncode == 0 and json.loads(done.stdout)["systems"], done.stderr
