"""The flags: what is no value of the range is refused by name, and the page of operations lists them all."""
import json
from pathlib import Path

import pytest

from conftest import program

DOCS = Path(__file__).resolve().parents[3] / "docs"
NUMBERS = ["--threads", "--max-sessions", "--principal-sessions"]
AMOUNTS = ["--principal-memory", "--memory"]
SECONDS = ["--grace", "--idle-timeout", "--max-connection-age", "--max-call-seconds"]


@pytest.mark.parametrize("arguments, told", [
    (["--frobnicate"], "The following argument was not expected: --frobnicate"),
    (["chek"], "The following argument was not expected: chek"),
    (["--threads"], "--threads: "), (["--threads", "x"], "--threads: 'x' must be a number"), (["token"], "NAME is required"),
])
def test_a_wrong_command_line(arguments, told):
    done = program(*arguments)
    assert done.returncode == 2 and done.stdout == "" and done.stderr.startswith(f"stiefel-server: error: {told}")


def test_an_unknown_variable_is_warned_of():
    unknown = {"STIEFEL_THREAD": "3", "STIEFEL_QUX": "1", "STIEFEL_PORT": "tcp://10.0.0.1:50551", "STIEFEL_SERVICE_HOST": "::1",
               "STIEFEL_PROXY_PORT_50551_TCP_ADDR": "10.0.0.1",
               **{f"STIEFEL_{name}": "" for name in ("ADDRESS", "SERVER", "TLS_CA", "TOKEN")}}
    told = ["STIEFEL_QUX: unknown variable", "STIEFEL_THREAD: unknown variable; did you mean STIEFEL_THREADS?"]
    checked = program("check", **unknown)
    assert checked.returncode == 0 and checked.stderr.splitlines() == [f"warning: {line}" for line in told]
    served = program("--listen", "127.0.0.1:0", "--exit-with-parent", STIEFEL_LOG_LEVEL="warn", STIEFEL_LOG_FORMAT="json",
                     **unknown)
    assert served.returncode == 0 and [json.loads(line)["message"] for line in served.stderr.splitlines()] == told


@pytest.mark.parametrize("value", ["nan", "-nan", "NAN", "inf", "-1", "1e400", "3x", " 3", "0x10", "1,5", "1GB"])
@pytest.mark.parametrize("flags", [NUMBERS, AMOUNTS, SECONDS], ids=["number", "amount", "seconds"])
def test_what_is_no_number_of_the_range(flags, value):
    """Every value for one flag of a kind, by flag; for the others one value, by variable."""
    for told in (program("check", f"{flags[0]}={value}"), program(f"{flags[0]}={value}")):
        assert told.returncode != 0 and told.stdout == ""
        assert flags[0] in told.stderr and f"'{value}' must be a number" in told.stderr
    for flag in flags if value == "nan" else []:
        told = program("check", **{"STIEFEL_" + flag[2:].upper().replace("-", "_"): value})
        assert told.returncode != 0 and "'nan' must be a number" in told.stderr
        assert flag not in NUMBERS or program("check", flag, "1.5").returncode != 0, "a fraction is no count"


@pytest.mark.parametrize("flag, value", [("--max-sessions", "0"), ("--idle-timeout", "0"), ("--threads", "1025"),
                                         ("--max-sessions", "4294967296"), ("--memory", "63M"), ("--listen", "127.0.0.1:65536")])
def test_values_beyond_the_range(flag, value):
    told = program("check", flag, value)
    assert told.returncode != 0 and f"{flag}: " in told.stderr and "must be" in told.stderr


@pytest.mark.parametrize("arguments", [[], ["--grace", "0"], ["--grace", "2.5e1", "--threads", "1024"]])
def test_sound_flags(arguments):
    told = program("check", *arguments)
    assert told.returncode == 0 and told.stdout.startswith("the flags are sound")


def test_the_page_of_operations_lists_the_flags():
    page = (DOCS / "operations.md").read_text(encoding="utf-8")
    begin, end = "<!-- stiefel-server flags -->\n", "<!-- end -->"
    assert page.split(begin)[1].split(end)[0].strip() == program("flags").stdout.strip()
    assert program("--help").returncode == program("--version").returncode == 0
