"""The examples in other languages print the Python client's bits, and the first calls of docs/languages.md run as printed."""
from __future__ import annotations

import json
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
EXAMPLES = ROOT / "client/examples"
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
def place(tmp_path: Path) -> Path:
    """Copies of the examples and the proto files, where they stand to each other as in the source."""
    shutil.copytree(EXAMPLES, tmp_path / "client/examples")
    shutil.copytree(ROOT / "proto", tmp_path / "proto")
    return tmp_path / "client/examples"


@pytest.fixture(scope="module")
def expected(server: stiefel.Server) -> list[tuple[str, list[float]]]:
    """What an example prints: a state, the samples of a stream, how it ended."""
    with stiefel.Client(server.address) as client, client.create(EXAMPLES / "scenes/tumbling_spacecraft.json") as session:
        step, run = session.step(100, "quaternion"), session.trajectory(1000, every=250, fields="quaternion")
        states = [(100, step["quaternion"])] + list(zip(run.step.tolist(), run["quaternion"]))
    return [(f"step {k}", quaternion.ravel().tolist()) for k, quaternion in states] + [("OUTCOME_REACHED", [])]


def read(text: str) -> list[tuple[str, list[float]]]:
    lines = (line.partition(":") for line in text.splitlines())
    return [(name, [float(number) for number in numbers.split()]) for name, _, numbers in lines]


def plugins_of_go() -> tuple[Path, ...]:
    tools.program("go")
    return tuple(tools.from_go(name).parent for name in PLUGINS)


def test_node(place: Path, server: stiefel.Server, expected: Any) -> None:
    modules = tools.from_npm() / "node_modules"
    assert read(run(["node", "example.js", server.address], place / "node", NODE_PATH=str(modules))) == expected


def test_go(place: Path, server: stiefel.Server, expected: Any) -> None:
    run(["go", "generate"], place / "go", plugins_of_go())
    assert run(["gofmt", "-l", "main.go"], place / "go") == ""
    assert read(run(["go", "run", ".", server.address], place / "go")) == expected


def test_rust(place: Path, server: stiefel.Server, expected: Any) -> None:
    target = tools.from_cargo(place / "rust")
    assert read(run(["cargo", "run", "--quiet", "--", server.address], place / "rust", CARGO_TARGET_DIR=str(target))) == expected


def test_the_page_of_the_browser_draws(place: Path) -> None:
    """Its script in Node, with a page that notes what is drawn: a box of 12 edges, turned by the sample's quaternion."""
    tools.program("node")
    script = re.search(r"<script>\n(.*)</script>", (place / "browser/index.html").read_text(), re.DOTALL)
    assert script is not None
    (place / "page.js").write_text("""
const drawn = [], text = {}, note = (x, y) => drawn.push([x, y]);
const noted = {clearRect() {}, beginPath() {}, stroke() {}, moveTo: note, lineTo: note};
const document = {body: {}, querySelector: (name) => name === 'canvas' ? {getContext: () => noted} : text};
const getComputedStyle = () => ({color: 'black'});
class EventSource {}
""" + script[1] + """
const half = Math.sqrt(0.5);  // a quarter turn about z
samples.onmessage({data: JSON.stringify({step: 3, time: 1.5, quaternion: [half, 0, 0, half]})});
console.log(JSON.stringify([drawn, text.textContent]));
""")
    drawn, text = json.loads(run(["node", "page.js"], place))
    assert len(drawn) == 24 and text == "step 3, 1.5 s, quaternion 0.7071 0.0000 0.0000 0.7071"
    corners = [(320 + 110 * a + 22 * c, 240 - 176 * b - 16.5 * c) for a in (-1, 1) for b in (-1, 1) for c in (-1, 1)]
    assert sorted({(round(x, 6), round(y, 6)) for x, y in drawn}) == sorted(corners)


@pytest.mark.parametrize("file", ["node/example.js", "go/main.go", "rust/src/main.rs"])
def test_an_example_is_short(file: str) -> None:
    assert len((EXAMPLES / file).read_text().splitlines()) <= 75


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
    plugins = plugins_of_go()
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


def test_the_versions_of_node_are_those_of_the_example() -> None:
    listed = json.loads((EXAMPLES / "node/package.json").read_text())["dependencies"]
    assert [f"{name}@{version}" for name, version in listed.items()] == tools.NPM
