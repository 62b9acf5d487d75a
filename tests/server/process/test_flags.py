"""The flags: what is no number of the range is refused by name, and the page of operations lists them all."""
import os
import subprocess
from pathlib import Path

import pytest

DOCS = Path(__file__).resolve().parents[3] / "docs"
NUMBERS = ["--threads", "--max-sessions", "--max-connections", "--store-limit", "--principal-sessions",
           "--principal-streams", "--principal-calls"]
AMOUNTS = ["--principal-work-rate", "--principal-queued-work", "--max-call-work", "--principal-memory"]
SECONDS = ["--grace", "--idle-timeout", "--max-connection-age", "--self-watch"]


def run(*arguments, **environment):
    return subprocess.run([os.environ["STIEFEL_SERVER"], *arguments], capture_output=True, text=True, timeout=20,
                          env={**os.environ, **environment})


@pytest.mark.parametrize("value", ["nan", "-nan", "NAN", "inf", "-inf", "-1", "1e400", "3x", " 3", "0x10", "1,5"])
@pytest.mark.parametrize("flag", NUMBERS + AMOUNTS + SECONDS)
def test_what_is_no_number_of_the_range(flag, value):
    for told in (run("check", f"{flag}={value}"), run(f"{flag}={value}")):
        assert told.returncode != 0 and told.stdout == ""
        assert flag in told.stderr and f"'{value}' must be a number" in told.stderr


@pytest.mark.parametrize("flag", NUMBERS + AMOUNTS + SECONDS)
def test_the_same_from_a_variable(flag):
    told = run("check", **{"STIEFEL_" + flag[2:].upper().replace("-", "_"): "nan"})
    assert told.returncode != 0 and "'nan' must be a number" in told.stderr


@pytest.mark.parametrize("flag", NUMBERS)
def test_a_fraction_is_no_count(flag):
    assert run("check", flag, "1.5").returncode != 0


@pytest.mark.parametrize("flag, value", [("--max-sessions", "0"), ("--idle-timeout", "0"), ("--threads", "1025"),
                                         ("--max-sessions", "4294967296")])
def test_numbers_beyond_the_range(flag, value):
    told = run("check", flag, value)
    assert told.returncode != 0 and f"{flag}: '{value}' must be" in told.stderr


@pytest.mark.parametrize("arguments", [[], ["--grace", "0"], ["--grace", "2.5e1", "--threads", "1024"],
                                       ["--max-connections", "10", "--self-watch", "10"]])
def test_sound_flags(arguments):
    told = run("check", *arguments)
    assert told.returncode == 0 and told.stdout.startswith("the flags are sound")


def test_check_looks_at_the_places_to_listen(tmp_path, serve):
    (tmp_path / "file").write_text("")
    for address, rule in [(f"unix:{tmp_path}/file", "is a file and no socket"),
                          (f"unix:{tmp_path}/none/socket", "No such file or directory"),
                          ("no.such.host.invalid:1", ""), ("127.0.0.1:65536", "0 to 65535")]:
        told = run("check", "--listen", address)
        assert told.returncode != 0 and "--listen: " in told.stderr and rule in told.stderr
    live = f"unix:{tmp_path}/socket"
    serve(listen=live)
    assert run("check", "--listen", live).returncode == 0, "a server that is to be replaced is no fault"


def test_check_knows_how_many_connections_there_can_be():
    told = run("check", "--max-connections", "1000000000")
    assert told.returncode == 1 and "--max-connections: 1000000000: must be at most" in told.stderr


def test_the_page_of_operations_lists_the_flags():
    page = (DOCS / "operations.md").read_text(encoding="utf-8")
    begin, end = "<!-- stiefel-server flags -->\n", "<!-- end -->"
    assert page.split(begin)[1].split(end)[0].strip() == run("flags").stdout.strip()
