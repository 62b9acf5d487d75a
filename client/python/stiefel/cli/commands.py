"""The commands: each makes its calls with the Python client and prints what they return."""
from __future__ import annotations

import argparse
import inspect
import math
import os
import sys
import tempfile
import warnings
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any, Callable, Iterator, Optional

from stiefel._given.when import time_of
from stiefel._results.html import text_table
from stiefel._results.load import load, rerun as run_again
from stiefel._results.save import WRITERS, complete, in_json, write_json
import stiefel.cli.given as read
import stiefel.cli.shown as shown
from stiefel.cli.given import BadInput
from stiefel.cli.interrupt import Interrupted
from stiefel.cli.options import told_as_errors
from stiefel.cli.progress import Progress
from stiefel._client import Client
from stiefel.errors import DeadlineExceeded, InvalidArgument, StiefelError, Unavailable
from stiefel.results import Outcome, RunStatus
from stiefel._server import Server
from stiefel._session import Session

REACHED, FAILED, BAD_INPUT, NUMERICAL_STOP, NO_SERVER, CLOSED_PIPE = 0, 1, 2, 3, 4, 141
Given = argparse.Namespace

_OUTPUTS = {"run": tuple(WRITERS), "rerun": tuple(WRITERS), "tradeoff": (".json", ".csv"), "report": (".html",)}


def perform(given: Given) -> int:
    """Runs a command and returns its exit status. Prints to stderr why it failed, a line for each fault."""
    with warnings.catch_warnings():
        warnings.simplefilter("always", UserWarning)
        warnings.showwarning = lambda text, *_, **__: print(f"warning: {text}", file=sys.stderr)
        status, faults = _performed(given)
    sys.stderr.write(told_as_errors(faults))
    return status


def _performed(given: Given) -> tuple[int, list[str]]:
    try:
        _read(given)
    except StiefelError as error:
        return BAD_INPUT, list(read.faults(error, given))
    except OSError as error:
        return BAD_INPUT, [f"{error.filename}: {error.strerror}"]
    except (BadInput, ValueError) as error:
        return BAD_INPUT, [str(error)]
    except ImportError as error:
        return FAILED, [str(error)]
    try:
        with _client(given) as client:
            status = _COMMANDS[given.command](given, client)
        sys.stdout.flush()
        return status, []
    except BrokenPipeError:
        return CLOSED_PIPE, []
    except BadInput as error:
        return BAD_INPUT, [str(error)]
    except StiefelError as error:
        away = isinstance(error, (Unavailable, DeadlineExceeded))
        wrong = isinstance(error, InvalidArgument) or error.violations
        return BAD_INPUT if wrong else NO_SERVER if away else FAILED, list(read.faults(error, given))
    except OSError as error:
        place = error.filename or getattr(given, "output", None) or "stdout"
        return FAILED, [f"cannot write to {place}: {error.strerror}"]
    except (ImportError, MemoryError, ValueError) as error:
        return FAILED, [str(error) or "not enough memory"]


def _read(given: Given) -> None:
    """Reads all files that the command line names, so that what is wrong with them is told before anything runs."""
    shown.check_output(getattr(given, "output", None), _OUTPUTS.get(given.command, (".json",)))
    if getattr(given, "scene", None):
        given.description = read.scene(given)
    if getattr(given, "times", None):
        given.times = read.times(given.times)
    if given.command in _FUNCTIONS:
        given.more = read.request(given.arguments if "arguments" in given else given.request, *_FUNCTIONS[given.command])
    if given.command == "rerun":
        given.saved = load(given.file)
    if given.command == "lyapunov" and given.checkpoint is not None:
        given.resumed = Path(given.checkpoint).read_bytes() if os.path.exists(given.checkpoint) else b""
    given.token = None if given.token_file is None else Path(given.token_file).read_text(encoding="utf-8").partition("\n")[0].strip()


@contextmanager
def _client(given: Given) -> Iterator[Client]:
    """Gives a client of the server of --server, or of one that the command starts."""
    with ExitStack() as ends:
        address = given.server or ends.enter_context(Server.start()).address
        tls = None if address.startswith("unix:") else given.tls
        client = Client(address, timeout=None, tls=tls, token=given.token)
        # After an interrupt gRPC may wait forever for a call that it was beginning; the process ends without it.
        ends.push(lambda kind, *_: None if kind is Interrupted else client.close())
        yield client


@contextmanager
def _session(given: Given, client: Client) -> Iterator[Session]:
    with client.create(given.description) as session:
        if session.choice is not None and sys.stderr.isatty():
            print(f"stiefel: chose {session.choice.method['name']}: {session.choice.reason}", file=sys.stderr)
        yield session


def _end(given: Given, session: Session) -> tuple[dict[str, Any], int]:
    """Returns the end of a run as an argument, and the step at or after it. Without one it is the scene's horizon."""
    if given.to is not None:
        return {"to": given.to}, given.to
    scene, time = session._resolved(), given.time
    if time is None:
        if not scene.HasField("horizon"):
            raise BadInput("--to is required, or --time: the scene has no horizon")
        time = math.copysign(scene.horizon, scene.step)
    return {"time": time}, math.ceil(time_of(time, scene.step, session.epoch)[1])


def _conclude(status: RunStatus, step: Optional[int] = None, what: str = "") -> int:
    if status.outcome is Outcome.REACHED:
        return REACHED
    after = "" if step is None else f" after step {step}"
    print(f"stiefel: {what}{status.outcome}{after}: {status.message}", file=sys.stderr)
    return NUMERICAL_STOP


def run(given: Given, client: Client) -> int:
    with _session(given, client) as session:
        end, to = _end(given, session) if given.times is None else ({"times": given.times}, len(given.times))
        with Progress(client, session, to):
            found = session.trajectory(**end, start=given.start or 0, every=given.every, fields=given.fields)
            last = max(0, int(found.step.max(initial=0)))
            diagnosis = session.diagnose(to=last, estimate_error=given.estimate_error)
    found, diagnosis = replace(found, estimated_error=diagnosis.estimated_error), replace(diagnosis, run_status=found.run_status)
    if given.output is not None:
        found.save(given.output)
    elif shown.is_table(given):
        print(shown.samples(found))
    else:
        write_json(found, sys.stdout)
    if given.output is not None or shown.is_table(given):
        shown.show(given, lambda: repr(diagnosis).removeprefix("<stiefel.Diagnosis ")[:-1], diagnosis)
    return _conclude(found.run_status, last)


def rerun(given: Given, client: Client) -> int:
    again = run_again(given.file, client=client)
    with ExitStack() as ends:
        file = given.output or f"{ends.enter_context(tempfile.TemporaryDirectory())}/again{Path(given.file).suffix}"
        again.save(file)
        now, saved = load(file), given.saved
    same = [*now.fields] == [*saved.fields] and all(
        one.tobytes() == other.tobytes() for one, other in zip((now.step, now.time, *now.fields.values()),
                                                               (saved.step, saved.time, *saved.fields.values())))
    builds = "" if now.build == saved.build else (
        f"; another build wrote the file: numerics id {saved.build}, here {now.build}")
    print(f"{given.file}: " + ("the same samples, to the last bit" if same else f"other samples{builds}"))
    return _conclude(again.run_status, int(again.step.max(initial=0))) if same else FAILED


def of_session(given: Given, client: Client) -> int:
    """Does what a method of Session does that has the command's name."""
    method = given.command.replace("-", "_")
    asked = {**read.arguments(given, getattr(Session, method)), **getattr(given, "more", {})}
    if method == "poincare":
        asked["section"] = {name: numbers for of in given.section for name, numbers in of.items()}
    if method == "lyapunov":
        asked["checkpoint"] = getattr(given, "resumed", b"")
    if method == "diagnose":
        asked["estimate_error"] = given.estimate_error
    with _session(given, client) as session:
        end, to = _end(given, session)
        with Progress(client, session, to):
            result = getattr(session, method)(**{**asked, **end})
    shown.tell(given, result.table if method == "diagnose" else shown.as_table(result), result)
    if getattr(given, "checkpoint", None):
        with complete(given.checkpoint) as part:
            Path(part).write_bytes(result.checkpoint)
    return _conclude(result.run_status, getattr(result, "step", None) if method in ("diagnose", "lyapunov") else None)


def summarize(given: Given, client: Client) -> int:
    events, fields = given.more.get("events"), given.more.get("fields")
    quantities = given.more.get("quantities", {})
    for of in given.quantities or ():
        quantities = {**quantities, **of} if isinstance(quantities, dict) else quantities
    if not quantities and not events:
        raise BadInput("give --quantities, or --arguments with quantities or events")
    with _session(given, client) as session:
        end, to = _end(given, session)
        with Progress(client, session, to):
            summary = session.summarize(**end, quantities=quantities, start=given.start or 0, every=given.every or 1)
            found = session.events(**end, events=events, start=given.start or 0, fields=fields) if events else None
    value = shown.plain(summary) if found is None else {**shown.plain(summary), "events": shown.plain(found)}
    shown.tell(given, shown.as_table(summary), value)
    return _conclude(summary.run_status, int(summary.last_step.max(initial=0)))


def tradeoff(given: Given, client: Client) -> int:
    found = client.tradeoff(given.description, progress=sys.stderr.isatty(),
                            **{name: getattr(given, name) for name in ("horizon", "budget", "repeats")})
    if given.output is not None:
        with complete(given.output) as part, open(part, "w", encoding="utf-8", newline="") as out:
            shown.points_csv(found, out) if given.output.endswith(".csv") else out.write(in_json(shown.plain(found)) + "\n")
    if given.output is None or sys.stdout.isatty():
        shown.show(given, shown.as_table(found), found)
    return REACHED


def convert(given: Given, client: Client) -> int:
    found = client.convert(given.description, system=given.system, epsilon=given.epsilon, parameter=given.parameter)
    if given.output is None:
        print(in_json(shown.plain(found)))
        return REACHED
    if found.scene is None:
        raise BadInput(f"--output: {given.system} is not a system, so there is no scene to write")
    with complete(given.output) as part:
        Path(part).write_text(in_json(found.scene) + "\n", encoding="utf-8")
    return REACHED


def _called(given: Given, function: Callable[..., Any]) -> Any:
    """Calls a function with the arguments of the file."""
    try:
        inspect.signature(function).bind(**given.more)
    except TypeError as error:
        raise BadInput(f"{given.request}: {error}") from None
    return function(**given.more)


def connect(given: Given, client: Client) -> int:
    if isinstance(given.more.get("pairs"), list):
        given.more["pairs"] = [tuple(one.values()) if isinstance(one, dict) else one for one in given.more["pairs"]]
    found = list(_called(given, client.geodesics))
    columns = ("outcome", "energy", "residual", "shortest")
    shown.tell(given, lambda: text_table(f"{len(found)} geodesics", ("pair", *columns), [
        (k, *(getattr(one, name) for name in columns)) for k, one in enumerate(found)]), {"geodesics": found})
    for k, one in enumerate(found):
        if one.outcome is not Outcome.REACHED:
            return _conclude(one.run_status, what=f"pair {k}: ")
    return REACHED


def conjugate_points(given: Given, client: Client) -> int:
    found = _called(given, client.conjugate_points)
    shown.tell(given, shown.as_table(found), found)
    return _conclude(found.run_status)


def report(given: Given, client: Client) -> int:
    from stiefel._report import page  # imported here because only pages need it

    name, file = Path(given.scene).stem if given.scene != "-" else None, given.output or "report.html"
    with _session(given, client) as session:
        _, to = _end(given, session)
        with Progress(client, session, to):
            last = session.step(to=to)
            page.write(file, session, to, name, given.member or 0, given.estimate_error is not False, given.tradeoff)
    print(f"wrote {file}")
    return _conclude(last.run_status, last.step)


def describe(given: Given, client: Client) -> int:
    found = client.describe()
    shown.tell(given, lambda: "\n".join(shown.catalogue(found)), found._message)
    return REACHED


_FUNCTIONS: dict[str, tuple[Callable[..., Any], ...]] = {
    "diagnose": (Session.diagnose,), "summarize": (Session.summarize, Session.events), "linearize": (Session.linearize,),
    "connect": (Client.geodesics,), "conjugate-points": (Client.conjugate_points,)}
_COMMANDS: dict[str, Callable[[Given, Client], int]] = {
    "run": run, "rerun": rerun, "tradeoff": tradeoff, "convert": convert, "connect": connect, "summarize": summarize,
    "conjugate-points": conjugate_points, "report": report, "describe": describe,
    **dict.fromkeys(("diagnose", "poincare", "linearize", "lyapunov"), of_session)}
