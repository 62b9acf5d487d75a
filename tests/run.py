#!/usr/bin/env python3
"""Runs CTest, and repeats at the end what each failed test printed last.

Usage: tests/run.py CTEST_ARGUMENT...

CTest prints the output of a failed test when that test ends, thousands of lines before its summary.
"""
from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Iterator
from xml.etree import ElementTree

LINES = 60  # of one test
TESTS = 10


def failures(report: Path) -> Iterator[tuple[str, str]]:
    """The names and outputs of the tests that failed, from CTest's JUnit file."""
    for test in ElementTree.parse(report).iter("testcase"):
        if test.get("status") == "fail":
            yield test.get("name", ""), test.findtext("system-out", "")


def main(arguments: list[str]) -> int:
    with tempfile.TemporaryDirectory() as folder:
        report = Path(folder, "tests.xml")
        code = subprocess.run(["ctest", *arguments, "--output-junit", str(report)]).returncode
        if code and report.exists():
            for name, output in list(failures(report))[:TESTS]:
                print(f"\n{name} printed last:")
                print("\n".join("  " + line for line in output.rstrip().splitlines()[-LINES:]), flush=True)
    return code


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
