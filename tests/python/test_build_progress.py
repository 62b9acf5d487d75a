"""What docker/build.py shows of a build without a terminal."""
from __future__ import annotations

import importlib.util
import os
import subprocess
import sys
from pathlib import Path
from typing import Iterator

import pytest

PROGRAM = Path(__file__).parents[2] / "docker/build.py"
specification = importlib.util.spec_from_file_location("build", PROGRAM)
build = importlib.util.module_from_spec(specification)
specification.loader.exec_module(build)


def shown(lines: list[str | None], seconds_a_line: float) -> list[str]:
    """What follow() shows of ninja's lines, each of which takes some seconds by its clock."""
    now = 0.0

    def output() -> Iterator[str | None]:
        nonlocal now
        for line in lines:
            now += seconds_a_line
            yield line

    out: list[str] = []
    build.follow(output(), out.append, clock=lambda: now)
    return out


def test_a_line_every_ten_seconds_and_not_one_a_file() -> None:
    out = shown([f"[{k}/100] Building CXX object {k}.o\n" for k in range(1, 101)], 1.0)
    assert 8 <= len(out) <= 12, out
    assert all(line.startswith("building: ") for line in out), out
    assert "of 100, about" in out[4] and "left" in out[4], out
    assert out[-1].startswith("building: 100 of 100"), out


def test_the_time_left_is_that_of_the_rest_at_the_same_speed() -> None:
    assert build.left(37, 106, 148) == ", about 5 min left"  # 69 more of 4 s
    assert build.left(100, 106, 400) == ", about 24 s left"
    assert build.left(4, 106, 10) == ""


def test_errors_are_shown_whole() -> None:
    lines = ["[1/2] Building CXX object a.o\n", "FAILED: a.o\n", "a.cc:1:1: error: no\n",
             "ninja: build stopped: subcommand failed.\n"]
    assert shown(lines, 0.1) == [line.rstrip("\n") for line in lines[1:]]


def test_a_build_with_nothing_to_do_says_nothing() -> None:
    assert shown(["ninja: no work to do.\n"], 0.1) == []


def test_a_slow_object_does_not_silence_it() -> None:
    out = shown(["[1/2] Building CXX object a.o\n", None, None, None], 10.0)
    assert len(out) >= 3 and all(line.startswith("building: 1 of 2") for line in out), out


def test_a_stream_without_lines_gives_none_after_each_wait() -> None:
    read, write = os.pipe()
    with os.fdopen(read) as stream, os.fdopen(write, "w") as ninja:
        lines = build.lines(stream, 0.01)
        assert next(lines) is None
        ninja.write("[1/2] Building CXX object a.o\n")
        ninja.close()
        assert [line for line in lines if line is not None] == ["[1/2] Building CXX object a.o\n"]


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
