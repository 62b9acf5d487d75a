#!/usr/bin/env python3
"""Builds and runs the programs of docs/cpp.md as a reader does, against installed libraries.

Usage: page.py PREFIX FOLDER CXX_FLAGS [SERVER]

That of the client runs against SERVER, the program stiefel-server, if it is given.
"""
import re
import subprocess
import sys
from pathlib import Path

prefix, folder, flags, *server = sys.argv[1:]
page = (Path(__file__).parents[2] / "docs/cpp.md").read_text(encoding="utf-8")
programs = list(zip(*(re.findall(rf"^```{language}\n(.*?)^```$", page, re.MULTILINE | re.DOTALL)
                      for language in ("cmake", "cpp"))))


def built(project: str, source: str) -> str:
    name, = re.findall(r"add_executable\((\w+) ", project)
    place = Path(folder, name)
    place.mkdir(parents=True, exist_ok=True)
    (place / "CMakeLists.txt").write_text(project)
    (place / f"{name}.cc").write_text(source)
    build = str(place / "build")
    subprocess.run(["cmake", "-S", str(place), "-B", build, f"-DCMAKE_PREFIX_PATH={prefix}", f"-DCMAKE_CXX_FLAGS={flags}"],
                   check=True)
    subprocess.run(["cmake", "--build", build], check=True)
    return f"{build}/{name}"


def output(*command: str) -> list[str]:
    out = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    print(out, end="")
    return out.splitlines()


engine, client = programs
lines = output(built(*engine))
said, = re.findall(r"first line of the output is `(.*?)`", page)
assert lines[0] == said and len(lines) == 4 and len(lines[1].split()) == 3, lines
if server:
    assert len(client[1].splitlines()) <= 25
    program = built(*client)
    command = [*server, "--listen", "127.0.0.1:0", "--exit-with-parent"]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdin and process.stdout
        lines = output(program, process.stdout.readline().split()[-1])
        process.stdin.close()
    rows = [[float(number) for number in line.replace(":", "").split()] for line in lines]
    assert [row[0] for row in rows] == [5.0 * sample for sample in range(11)], lines
    for _, *omega in rows:  # the kinetic energy, to the six digits that are printed
        energy = sum(moment * speed**2 for moment, speed in zip((1, 2, 3), omega)) / 2
        assert abs(energy - 1.000002) < 2e-5, (omega, energy)
