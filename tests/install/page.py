#!/usr/bin/env python3
"""Builds and runs the program of docs/cpp.md as a reader does, against an installed library.

Usage: page.py PREFIX FOLDER CXX_FLAGS
"""
import re
import subprocess
import sys
from pathlib import Path

prefix, folder, flags = sys.argv[1:]
page = (Path(__file__).parents[2] / "docs/cpp.md").read_text(encoding="utf-8")
blocks = dict(re.findall(r"^```(cmake|cpp)\n(.*?)^```$", page, re.MULTILINE | re.DOTALL))
Path(folder).mkdir(parents=True, exist_ok=True)
Path(folder, "CMakeLists.txt").write_text(blocks["cmake"])
Path(folder, "top.cc").write_text(blocks["cpp"])
build = str(Path(folder, "build"))
subprocess.run(["cmake", "-S", folder, "-B", build, f"-DCMAKE_PREFIX_PATH={prefix}", f"-DCMAKE_CXX_FLAGS={flags}"], check=True)
subprocess.run(["cmake", "--build", build], check=True)
out = subprocess.run([f"{build}/top"], check=True, capture_output=True, text=True).stdout
said, = re.findall(r"first line of the output is `(.*?)`", page)
lines = out.splitlines()
assert lines[0] == said and len(lines) == 4 and len(lines[1].split()) == 3, out
print(out, end="")
