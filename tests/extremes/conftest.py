"""Starts servers, and writes the records from which the report is made."""
import json
import os
import time
from pathlib import Path

import pytest

import stiefel

LONG = os.environ.get("STIEFEL_EXTREMES") == "long"
SANITIZED = "STIEFEL_SANITIZED" in os.environ  # whether the server is built with a sanitizer, which takes memory


@pytest.fixture(scope="session")
def server():
    with stiefel.Server.start(arguments=["--threads", "2"]) as server:
        yield server


@pytest.fixture(scope="session")
def client(server):
    with stiefel.Client(server.address, timeout=None) as client:
        yield client


@pytest.fixture(scope="session")
def cpu_seconds(server):
    """Returns the CPU seconds of all threads of the server so far, which do not depend on other programs."""
    def cpu_seconds():
        fields = Path(f"/proc/{server.process.pid}/stat").read_text().rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
    return cpu_seconds


@pytest.fixture(scope="session")
def records():
    """The file to which the long form appends, emptied at the start; None in the short form."""
    if not LONG:
        yield None
        return
    folder = Path(os.environ.get("STIEFEL_RECORDS", "."))
    folder.mkdir(parents=True, exist_ok=True)
    with open(folder / "service.jsonl", "w", encoding="utf-8") as file:
        yield file


@pytest.fixture
def record(records):
    """Writes what a row measured, without judging it: the tests assert where they measure."""
    start = time.monotonic()

    def record(row, measure, value, bound=None, why=None, outcome="REACHED", system="rigid_body",
               method="variational", limit=None):
        if records is None:
            return
        print(json.dumps({
            "extreme": "service", "row": row, "system": system, "method": method, "order": None,
            "arithmetic": None, "precision": None, "outcome": outcome, "measure": measure, "value": value,
            "bound": bound, "why": why, "seconds": round(time.monotonic() - start, 3), "limit": limit,
        }), file=records, flush=True)
    return record
