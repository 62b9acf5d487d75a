"""mypy --strict and pyright: they accept a scene of every kind, the package itself and every example, and find a misspelt key,
method, system or field."""
from __future__ import annotations

import json
import os
import shutil
import subprocess
from pathlib import Path

import pytest
import tools

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = ["client/examples/*.py", "docs/integrability.py", "docs/gallery/*.py"]
PACKAGE = Path(os.environ["PYTHONPATH"].split(os.pathsep)[0])
RIGHT = """
import datetime
import numpy as np
import stiefel

Q = np.eye(4)
scene: stiefel.Scene = {"system": "rigid_body", "inertia": [1, 2, 3, 4], "initial": {"Q": Q, "Omega": Q - Q.T}, "step": 0.1,
                        "method": {"name": "variational", "order": 4}, "epoch": datetime.datetime(2026, 1, 1)}
run = stiefel.simulate(scene, time=3.0, fields=["Q", "M"])
asteroid = stiefel.examples["toutatis"]
asteroid["step"] = 3
stiefel.simulate(asteroid, to=3)
with stiefel.Client() as client, client.create({**scene, "step": 0.2}) as session:
    session.fork(at=2, initial={"M": Q - Q.T}, method={"name": "rk4"})
    client.create(session.scene)
    session.step(to=3, fields="Q")
"""
# What is returned and yielded has the types of the blocking client.
ASYNCHRONOUS = """
import asyncio
import stiefel.aio

async def main() -> None:
    async with stiefel.aio.Client() as client, client.create("toutatis") as session, session.drive("Q") as drive:
        states: list[stiefel.State] = [await session.step(to=3, fields="Q"), await drive.step(4)]
        async for batch in session.stream(to=9, every=3):
            samples: stiefel.Batch = batch
        run: stiefel.Trajectory = await session.trajectory(time=9.0, fields=["quaternion"])
        fork: stiefel.aio.Session = await session.fork(at=2)
        scene: stiefel.Scene = await fork.scene
        ids: list[str] = [one.id async for one in client.list()]

asyncio.run(main())
"""
WRONG = {
    "a key": 'stiefel.simulate({"system": "rigid_body", "bodi": {}, "step": 1.0}, to=3)',
    "a key inside": 'stiefel.simulate({"system": "rigid_body", "body": {"moment": [1, 2, 3]}, "step": 1.0}, to=3)',
    "a block": 'stiefel.simulate({"system": "rigid_body", "initial": {"R": [[1]]}, "step": 1.0}, to=3)',
    "a method": 'stiefel.simulate({"system": "rigid_body", "method": {"name": "rk5"}, "step": 1.0}, to=3)',
    "a system": 'stiefel.simulate({"system": "rigid_boddy", "step": 1.0}, to=3)',
    "a field": 'stiefel.simulate("toutatis", to=3, fields=["quaternoin"])',
}


@pytest.fixture(scope="session")
def programs() -> Path:
    return tools.from_pypi("checkers")


@pytest.fixture(params=["mypy", "pyright"])
def command(request: pytest.FixtureRequest, programs: Path) -> list[str]:
    """The beginning of a command that checks."""
    # An installed package, whose own files are not checked.
    place = next((programs.parent / "lib").glob("python3*/site-packages"))
    (place / "stiefel.pth").write_text(f"{PACKAGE}\n")
    return {"mypy": [str(programs / "mypy"), "--strict"],
            "pyright": [str(programs / "pyright"), "--pythonpath", str(programs / "python")]}[request.param]


def run(command: list[str], folder: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(command, cwd=folder, capture_output=True, text=True,
                          env={name: value for name, value in os.environ.items() if name != "PYTHONPATH"})


def assert_accepted(command: list[str], folder: Path) -> None:
    """No file in the folder has an error. Packages that only some functions need are not installed, and the modules that
    protoc writes have errors."""
    shutil.copy(PACKAGE / "pyproject.toml", folder)
    (folder / "pyrightconfig.json").write_text(json.dumps({
        "exclude": ["stiefel/v1"], "reportMissingImports": "none", "reportMissingModuleSource": "none"}))
    done = run([*command, *([] if "--pythonpath" in command else ["."])], folder)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.fixture
def check(command: list[str], tmp_path: Path):
    """Returns the lines with errors of a program."""
    def lines(program: str) -> list[int]:
        (tmp_path / "program.py").write_text(program)
        done = run([*command, "program.py"], tmp_path)
        assert "program.py" in done.stdout or done.returncode == 0, done.stdout + done.stderr
        return [int(line.split("program.py:")[1].split(":")[0]) for line in done.stdout.splitlines()
                if "program.py:" in line and "error:" in line]

    return lines


def test_right_scenes_are_accepted(check):
    assert check(RIGHT) == []


def test_programs_with_asyncio_are_accepted_where_they_are_right(check):
    assert check(ASYNCHRONOUS) == []
    for right, wrong in (("session.step(to=3", "session.step(too=3"), ('fields="Q"', 'fields="quaternoin"'),
                         ("samples: stiefel.Batch", "samples: stiefel.State"), ("await session.fork", "session.fork"),
                         ('create("toutatis")', "create(3)")):
        assert check(ASYNCHRONOUS.replace(right, wrong)) != [], wrong


@pytest.mark.parametrize("files", EXAMPLES)
def test_the_examples_are_accepted(command, tmp_path, files):
    for file in ROOT.glob(files):  # some import others beside them
        shutil.copy(file, tmp_path)
    assert_accepted(command, tmp_path)


def test_the_package_itself_is_accepted(command, tmp_path):
    shutil.copytree(PACKAGE / "stiefel", tmp_path / "stiefel", ignore=shutil.ignore_patterns("__pycache__"))
    assert_accepted(command, tmp_path)


@pytest.mark.parametrize("what", WRONG)
def test_what_is_misspelt_is_found(check, what):
    assert check(f"import stiefel\n{WRONG[what]}\n") == [2]
