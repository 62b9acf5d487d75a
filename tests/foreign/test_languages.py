"""The first calls of docs/languages.md run as printed."""
from __future__ import annotations

import os
import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest

import stiefel
import tools

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs/languages.md").read_text(encoding="utf-8")
PRINTED = "127.0.0.1:50551"
PLUGINS = ("protoc-gen-go", "protoc-gen-go-grpc")


def blocks(heading: str) -> dict[str, str]:
    """The blocks of code of a part of the page, by their languages."""
    part = re.search(rf"^## {heading}\n(.*?)(?=^## |\Z)", PAGE, re.DOTALL | re.MULTILINE)
    assert part is not None
    return dict(re.findall(r"```(\w+)\n(.*?)```", part[1], re.DOTALL))


def run(command: "list[Any]", folder: Path, path: "tuple[Path, ...]" = (), **environment: str) -> str:
    places = os.pathsep.join([*map(str, path), os.environ["PATH"]])
    done = subprocess.run(command, cwd=folder, env={**os.environ, "PATH": places, **environment}, capture_output=True, text=True,
                          timeout=60 * tools.MINUTES)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture
def first(tmp_path: Path) -> Path:
    """The folder from which the page's programs run."""
    shutil.copytree(ROOT / "proto", tmp_path / "proto")
    return tmp_path


def written(heading: str, language: str, name: str, address: str, folder: Path) -> str:
    """Writes a program of the page, which has at most 15 lines, and returns the commands that run it."""
    page = blocks(heading)
    assert len(page[language].splitlines()) <= 15 and PRINTED in page[language]
    (folder / name).write_text(page[language].replace(PRINTED, address))
    return page["sh"]


def test_the_first_call_from_node(first: Path, server: stiefel.Server) -> None:
    modules = tools.from_npm()
    commands = written("Node", "js", "first.js", server.address, first)
    install, start = commands.splitlines()
    assert install.split() == ["npm", "install", *tools.NPM]
    shutil.copytree(modules / "node_modules", first / "node_modules")
    assert run(["sh", "-ec", start], first).strip() == stiefel.__version__


def test_the_first_call_from_go(first: Path, server: stiefel.Server) -> None:
    tools.program("go")
    plugins = tuple(tools.from_go(name).parent for name in PLUGINS)
    commands = written("Go", "go", "main.go", server.address, first)
    assert [line for line in commands.splitlines() if "install" in line] == [f"go install {tools.GO[name]}" for name in PLUGINS]
    started = "\n".join(line for line in commands.splitlines() if "install" not in line)
    assert run(["sh", "-ec", started], first, plugins).split() == [stiefel.__version__, "<nil>"]
    assert run(["gofmt", "-l", "main.go"], first) == ""


def test_the_first_call_from_rust(first: Path, server: stiefel.Server) -> None:
    tools.program("cargo")
    part = re.search(r"^## Rust\n(.*?)(?=^## )", PAGE, re.DOTALL | re.MULTILINE)
    assert part is not None
    (commands,), (build, main) = (re.findall(rf"```{language}\n(.*?)```", part[1], re.DOTALL) for language in ("sh", "rust"))
    assert len((build + main).splitlines()) <= 15 and PRINTED in main
    *made, start = commands.splitlines()
    run(["sh", "-ec", "\n".join(made)], first)
    (first / "build.rs").write_text(build)
    (first / "src/main.rs").write_text(main.replace(PRINTED, server.address))
    target = tools.from_cargo(first)
    assert start == "cargo run"
    assert run(["cargo", "run", "--quiet"], first, CARGO_TARGET_DIR=str(target)).strip() == stiefel.__version__


def test_a_server_gives_its_proto_files(server: stiefel.Server, tmp_path: Path) -> None:
    command = re.search(r"```sh\n(grpcurl .*)\n```", PAGE)
    assert command is not None
    run(["sh", "-ec", command[1].replace(PRINTED, server.address)], tmp_path, (tools.from_go("grpcurl").parent,))
    there = sorted(str(file.relative_to(tmp_path / "proto")) for file in (tmp_path / "proto").rglob("stiefel/v1/*.proto"))
    assert there == sorted(f"stiefel/v1/{file.name}" for file in (ROOT / "proto/stiefel/v1").glob("*.proto"))
    run(["protoc", "-Iproto", "--java_out=.", *there], tmp_path)
    assert (tmp_path / "stiefel/v1/Scene.java").exists()
