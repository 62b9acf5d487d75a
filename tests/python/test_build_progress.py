"""What docker/build.py shows of a build without a terminal."""
from __future__ import annotations

import importlib.util
import subprocess
import sys
from pathlib import Path

import pytest

PROGRAM = Path(__file__).parents[2] / "docker/build.py"
specification = importlib.util.spec_from_file_location("build", PROGRAM)
build = importlib.util.module_from_spec(specification)
specification.loader.exec_module(build)


def test_errors_are_shown_whole() -> None:
    lines = ["[1/2] Building CXX object a.o\n", "FAILED: a.o\n", "a.cc:1:1: error: no\n",
             "ninja: build stopped: subcommand failed.\n"]
    out: list[str] = []
    build.follow(iter(lines), out.append, clock=lambda: 0.0)
    assert out == [line.rstrip("\n") for line in lines[1:]]


@pytest.mark.parametrize("fails", [False, True])
def test_its_exit_status_is_the_builds(tmp_path: Path, fails: bool) -> None:
    (tmp_path / "CMakeLists.txt").write_text(
        "cmake_minimum_required(VERSION 3.25)\nproject(one NONE)\n"
        f"add_custom_target(one COMMAND ${{CMAKE_COMMAND}} -E {'false' if fails else 'true'})\n")
    (tmp_path / "CMakePresets.json").write_text(
        '{"version": 6, "configurePresets": [{"name": "p", "generator": "Ninja", "binaryDir": "${sourceDir}/b"}],'
        ' "buildPresets": [{"name": "p", "configurePreset": "p"}]}')
    subprocess.run(["cmake", "--preset", "p"], cwd=tmp_path, check=True, capture_output=True)
    done = subprocess.run([sys.executable, str(PROGRAM), "p", "1", "one"], cwd=tmp_path, capture_output=True, text=True)
    assert (done.returncode != 0) == fails, done.stdout
    assert ("FAILED" in done.stdout) == fails, done.stdout
