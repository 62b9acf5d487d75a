"""The flags: what is no number of the range is refused by name, and the page of operations lists them all."""
import json
import os
import subprocess
from pathlib import Path

import pytest

DOCS = Path(__file__).resolve().parents[3] / "docs"
NUMBERS = ["--threads", "--max-sessions", "--principal-sessions"]
AMOUNTS = ["--principal-memory"]
SECONDS = ["--grace", "--idle-timeout", "--max-connection-age", "--max-call-seconds"]


def run(*arguments, **environment):
    return subprocess.run([os.environ["STIEFEL_SERVER"], *arguments], capture_output=True, text=True, timeout=20,
                          env={**os.environ, **environment})


@pytest.mark.parametrize("arguments, told", [
    (["--frobnicate"], "The following argument was not expected: --frobnicate"),
    (["check", "--lisen=unix:x"], "The following argument was not expected: --lisen=unix:x"),
    (["chek"], "The following argument was not expected: chek"),
    (["--threads"], "--threads: "), (["--threads", "x"], "--threads: 'x' must be a number"), (["token"], "NAME is required"),
])
def test_a_wrong_command_line(arguments, told):
    done = run(*arguments)
    assert done.returncode == 2 and done.stdout == "" and done.stderr.startswith(f"stiefel-server: error: {told}")


def test_help_and_version_are_no_faults():
    assert run("--help").returncode == run("--version").returncode == 0


@pytest.mark.parametrize("form", ["text", "json"])
def test_an_unknown_variable_is_warned_of(form):
    unknown = {"STIEFEL_THREAD": "3", "STIEFEL_QUX": "1", "STIEFEL_PORT": "tcp://10.0.0.1:50551",
               "STIEFEL_PROXY_PORT_50551_TCP_ADDR": "10.0.0.1", "STIEFEL_TOKEN": "of a client"}
    done = subprocess.run([os.environ["STIEFEL_SERVER"], "--listen", "127.0.0.1:0", "--exit-with-parent"], text=True,
                          stdin=subprocess.DEVNULL, capture_output=True, timeout=60,
                          env={**os.environ, **unknown, "STIEFEL_LOG_LEVEL": "warn", "STIEFEL_LOG_FORMAT": form})
    lines = [json.loads(line)["message"] if form == "json" else line for line in done.stderr.splitlines()]
    assert done.returncode == 0 and len(lines) == 2
    assert lines[0].endswith("STIEFEL_QUX: unknown variable")
    assert lines[1].endswith("STIEFEL_THREAD: unknown variable; did you mean STIEFEL_THREADS?")


def test_check_warns_of_an_unknown_variable():
    done = run("check", STIEFEL_THREAD="3")
    assert done.returncode == 0 and done.stderr == "warning: STIEFEL_THREAD: unknown variable; did you mean STIEFEL_THREADS?\n"


def test_the_variables_of_clients_are_known():
    assert run("check", **{f"STIEFEL_{name}": "" for name in ("ADDRESS", "SERVER", "TLS_CA", "TOKEN")}).stderr == ""


@pytest.mark.parametrize("value", ["nan", "-nan", "NAN", "inf", "-inf", "-1", "1e400", "3x", " 3", "0x10", "1,5"])
@pytest.mark.parametrize("flags", [NUMBERS, AMOUNTS, SECONDS], ids=["number", "amount", "seconds"])
def test_what_is_no_number_of_the_range(flags, value):
    """Every value for one flag of a kind, by flag; for the others one value, by variable."""
    for told in (run("check", f"{flags[0]}={value}"), run(f"{flags[0]}={value}")):
        assert told.returncode != 0 and told.stdout == ""
        assert flags[0] in told.stderr and f"'{value}' must be a number" in told.stderr
    for flag in flags if value == "nan" else []:
        told = run("check", **{"STIEFEL_" + flag[2:].upper().replace("-", "_"): value})
        assert told.returncode != 0 and "'nan' must be a number" in told.stderr
        assert flag not in NUMBERS or run("check", flag, "1.5").returncode != 0, "a fraction is no count"


@pytest.mark.parametrize("flag, value", [("--max-sessions", "0"), ("--idle-timeout", "0"), ("--threads", "1025"),
                                         ("--max-sessions", "4294967296")])
def test_numbers_beyond_the_range(flag, value):
    told = run("check", flag, value)
    assert told.returncode != 0 and f"{flag}: '{value}' must be" in told.stderr


@pytest.mark.parametrize("arguments", [[], ["--grace", "0"], ["--grace", "2.5e1", "--threads", "1024"]])
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


def test_the_page_of_operations_lists_the_flags():
    page = (DOCS / "operations.md").read_text(encoding="utf-8")
    begin, end = "<!-- stiefel-server flags -->\n", "<!-- end -->"
    assert page.split(begin)[1].split(end)[0].strip() == run("flags").stdout.strip()
