"""The command line of `stiefel`. Options have the names of the arguments of the Python functions that a command calls."""
from __future__ import annotations

import argparse
import difflib
import json
import re
import sys
from typing import Any, NoReturn, Sequence

from stiefel.version import __version__

_ENDING = """\
Exit status: 0 reached, 2 bad input, 3 numerical stop (what was reached is written), 4 no server at the address, 1 any other
failure. After Ctrl-C or SIGTERM a command says which step it reached, leaves no incomplete file and ends by the signal
(status 130, 143). On a terminal a command prints tables, and shows its progress after a second; elsewhere it prints JSON.
"""


class _Parser(argparse.ArgumentParser):
    """A parser that names the nearest option or command of a misspelt one."""

    commands: dict[str, _Parser]

    def __init__(self, **more: Any):
        super().__init__(allow_abbrev=False, **more)
        self._negative_number_matcher = re.compile(r"-(\d+\.?\d*|\.\d+)(e[-+]?\d+)?$", re.IGNORECASE)  # argparse's lacks -1e3

    def error(self, message: str) -> NoReturn:
        told = re.sub(r"^argument ", "", message)
        sys.stderr.write(f"{told_as_errors([told])}See {self.prog} --help\n")
        sys.exit(2)

    def near(self, given: str) -> str:
        """Returns what is wrong with an argument that is left over."""
        if not given.startswith("-"):
            return f"unexpected argument {given}"
        word = given.partition("=")[0]
        known = [option for action in self._actions for option in action.option_strings if option.startswith("--")]
        found = difflib.get_close_matches("-" * (2 - len(word) + len(word.lstrip("-"))) + word, known, n=1)
        return f"unknown option {word}" + (f"; did you mean {found[0]}?" if found else "")


def told_as_errors(lines: Sequence[str]) -> str:
    return "".join(f"stiefel: error: {line}\n" for line in lines)


def parser() -> _Parser:
    """Returns the parser of the command line; its `commands` are those of the commands, by their names."""
    made = _Parser(prog="stiefel", epilog=_ENDING, formatter_class=argparse.RawDescriptionHelpFormatter, description=(
        "Simulates torque-free rigid bodies in any dimension and geodesics on Stiefel manifolds, and reports how accurate the "
        "result is."))
    made.add_argument("--version", action="version", version=__version__)
    several = made.add_subparsers(dest="command", metavar="COMMAND", prog="stiefel")
    made.commands = {name: _added(several, name) for name in sorted(COMMANDS)}
    return made


def parse(arguments: Sequence[str]) -> argparse.Namespace:
    """Reads a command line. Prints help, version or what is wrong and raises SystemExit with the exit status."""
    every = parser()
    commands = every.commands
    first = next((word for word in arguments if not word.startswith("-")), None)
    if first is None and not {"-h", "--help", "--version"} & {*arguments}:
        faults = [every.near(word) for word in arguments] or [f"a command is required: {', '.join(commands)}"]
        every.error("\nstiefel: error: ".join(faults))
    if first is not None and first not in commands:
        found = difflib.get_close_matches(first.lower(), commands, n=1)
        every.error(f"unknown command {first}; " + (f"did you mean {found[0]}?" if found else f"the commands are {', '.join(commands)}"))
    given, left = every.parse_known_args(arguments)
    chosen = commands[given.command]
    if left:
        chosen.error("\nstiefel: error: ".join(map(chosen.near, left)))
    if getattr(given, "token_file", None) and not given.server:
        chosen.error("--token-file: needs --server")
    return given


def _added(several: Any, name: str) -> _Parser:
    summary, options = COMMANDS[name]
    parser: _Parser = several.add_parser(name, help=summary, description=f"{summary}.")
    ends = parser.add_mutually_exclusive_group() if "to" in options.split() else parser  # no empty group: Python 3.11 refuses its help
    for option in [*options.split(), "server", "tls", "token-file", "json"]:
        more = {**_OPTIONS[option.rstrip("!")], **({"required": True} if option.endswith("!") else {})}
        names = [option] if option in _POSITIONAL else [f"--{option.rstrip('!')}"]
        (ends if option in ("to", "time", "times") else parser).add_argument(*names, **more)
    return parser


def whole(text: str) -> int:
    """Reads a whole number in any form, such as 30, 3e1 and 30.0."""
    try:
        number = int(text) if re.fullmatch(r"[-+]?\d+", text) else float(text)
        if number == int(number):
            return int(number)
    except (ValueError, OverflowError):
        pass
    raise argparse.ArgumentTypeError(f"{text}: must be a whole number")


def names(text: str) -> list[str]:
    """Splits names at commas outside of brackets, as of "energy,manakov[3,1]"."""
    return re.split(r",(?![^\[]*\])", text)


def value(text: str) -> Any:
    """Returns JSON, a list of numbers or texts separated by commas, or the text."""
    try:
        return json.loads(text)
    except ValueError:
        return [value(part) for part in names(text)] if "," in text else text


def linear(text: str) -> dict[str, list[float]]:
    """Reads a linear function of a field: "q=0,0,1"."""
    field, _, numbers = text.partition("=")
    try:
        found = {field: [float(number) for number in numbers.split(",")]}
    except ValueError:
        found = {}
    if not field or not found:
        raise argparse.ArgumentTypeError(f"{text}: must be FIELD=NUMBER,NUMBER,...")
    return found


def statistics(text: str) -> dict[str, list[str]]:
    """Reads a quantity with its statistics: "energy=drift,last"."""
    quantity, _, wanted = text.partition("=")
    if not quantity or not wanted:
        raise argparse.ArgumentTypeError(f"{text}: must be NAME=STATISTIC,...")
    return {quantity: wanted.split(",")}


_FLAG: dict[str, Any] = {"action": "store_true", "default": None}
_SWITCH: dict[str, Any] = {"action": argparse.BooleanOptionalAction, "default": None}
_POSITIONAL = ("scene", "file", "request")
_OPTIONS: dict[str, dict[str, Any]] = {
    "scene": dict(metavar="SCENE", help="a scene file in JSON; - for stdin; or the name of an example, such as toutatis"),
    "set": dict(dest="changes", metavar="FIELD=VALUE", action="append", default=[], help=(
        "a field that replaces that of the scene; null removes it. Repeatable. Example: body.angular_velocity=0.1,1,0.2")),
    "to": dict(type=whole, metavar="STEP", help="the last step; by default that of the scene's horizon"),
    "time": dict(type=value, metavar="TIME", help=(
        "the last time instead: seconds, or an instant in ISO 8601 where the scene has an epoch")),
    "times": dict(metavar="FILE", help=(
        "a file of times, separated by white space, on both sides of time 0: samples at these times instead of at steps")),
    "start": dict(type=whole, metavar="STEP", help="the first step; 0 by default"),
    "every": dict(type=whole, metavar="K", help=(
        "the steps between two samples or results, the last one always included; by default `run` gives about 1000 samples, "
        "`summarize` takes every step, others give the last result alone")),
    "fields": dict(type=names, metavar="Q,M,...", help=(
        "fields, separated by commas, as `stiefel describe` lists them; by default quaternion and angular_velocity of a scene with "
        "`body`, otherwise the system's blocks")),
    "estimate-error": dict(_SWITCH, help=(
        "estimate the error of the last state, or do not; by default where that takes less work than the run or less than 10 ms, on "
        "a page at most about ten seconds")),
    "output": dict(metavar="FILE", help=(
        "a file instead of stdout: .json; for samples also .csv and .npz, as Trajectory.save writes them; for "
        "a trade-off also .csv; for a page .html")),
    "file": dict(metavar="FILE", help="a file of samples that `stiefel run` or Trajectory.save wrote; status 1: the samples differ"),
    "invariants": dict(type=names, metavar="A,B,...", help=(
        "families or single invariants, separated by commas; by default all families, the Manakov coefficients only up to N = 16")),
    "symplectic": dict(_FLAG, help="measure how far a step is from keeping the two-form"),
    "horizon": dict(type=float, metavar="T", help=(
        "the time at which errors are measured; by default the scene's horizon, else 100 steps")),
    "budget": dict(type=float, metavar="B", help=(
        "work in instructions; by default 5e10, about ten seconds. Where it does not suffice, all points are measured over the same "
        "part of the horizon and extrapolated")),
    "repeats": dict(type=whole, metavar="R", help="timed runs of each point; by default 3"),
    "system": dict(metavar="SYSTEM", help="the target: a system, or velocity, angular_velocity, interpolation"),
    "epsilon": dict(type=float, help="of symmetric and parametric systems; by default a power of two chosen from the norm of M"),
    "parameter": dict(type=float, help="mu of the parametric systems; by default the scene's"),
    "quantities": dict(type=statistics, nargs="+", action="extend", metavar="NAME=A,B,...", help=(
        "NAME is a field, an invariant or a family of invariants; A, B, ... are among last, min, max, mean, rms, sign_changes, "
        "drift. Example: energy=drift quaternion=last")),
    "section": dict(type=linear, nargs="+", action="extend", metavar="FIELD=NUMBER,...", help=(
        "the plane sum(NUMBER * FIELD) = level; the numbers row by row: q=0,0,1. The sums of several fields are added")),
    "level": dict(type=float, metavar="NUMBER", help="0 by default"),
    "direction": dict(choices=("rising", "falling", "both"), help="rising by default"),
    "coordinates": dict(type=linear, nargs="+", action="extend", metavar="FIELD=NUMBER,...", help=(
        "linear functions of fields, the numbers of each point")),
    "inertia": dict(_FLAG, help="add the derivatives by lambda_1 ... lambda_N"),
    "step": dict(_FLAG, help="add the derivative by the step"),
    "arguments": dict(metavar="FILE.json", help=(
        "a file with more arguments of the Python function: forms and dirac_brackets of Session.diagnose; quantities, events and "
        "fields of Session.summarize and Session.events; vectors of Session.linearize")),
    "count": dict(type=whole, metavar="K", help="the K largest exponents; all by default"),
    "interval": dict(type=whole, metavar="STEPS", help="steps between two orthonormalisations; by default about a radian of the motion"),
    "seed": dict(type=whole, help="of the random first vectors; 0 by default"),
    "checkpoint": dict(metavar="FILE", help=(
        "a file of where the exponents end. Where it exists the command goes on from there, with the same scene and options but a "
        "later last step; it writes the new one there")),
    "request": dict(metavar="FILE", help=(
        "a JSON file with the arguments of a Python function; - for stdin. `connect`: those of Client.geodesics, {inertia, pairs: "
        "[[Q_0, Q_T], ...], time}, as the example frames has them. "
        "`conjugate-points`: those of Client.conjugate_points, {inertia, Q, Qdot, time}")),
    "member": dict(type=whole, metavar="I", help="the member of an ensemble to draw; 0 by default"),
    "tradeoff": dict(_SWITCH, help=(
        "measure error against cost of every method for about ten seconds, or do not; by default for about a second, and not for "
        "ensembles")),
    "server": dict(metavar="ADDRESS", help="HOST:PORT or unix:PATH of a server; by default the command starts one"),
    "tls": dict(metavar="FILE", help=(
        "PEM file of the authorities that signed the server's certificate; connects with TLS. By default the variable STIEFEL_TLS_CA")),
    "token-file": dict(metavar="FILE", help=(
        "file of the token that identifies the caller; by default the token is the variable STIEFEL_TOKEN")),
    "json": dict(action="store_true", help="print JSON on a terminal too"),
}
COMMANDS = {  # what each does, and its options; "!" marks those that are required
    "run": ("Runs a scene and writes samples", "scene set to time times start every fields estimate-error output"),
    "rerun": ("Runs the scene of a file of samples again and compares the samples, bit by bit", "file output"),
    "diagnose": ("Prints invariants, drift, estimated error and domain at a step",
                 "scene set to time invariants symplectic estimate-error arguments output"),
    "tradeoff": ("Measures error against cost of every method and prints the Pareto front, the points that no other point beats in "
                 "both", "scene set horizon budget repeats output"),
    "convert": ("Prints the same motion as a scene of another system", "scene set system! epsilon parameter output"),
    "connect": ("Finds the geodesics that join pairs of frames in a given time", "request output"),
    "summarize": ("Prints statistics and events of a motion without its samples",
                  "scene set to time start every quantities arguments output"),
    "poincare": ("Prints where a motion crosses a plane in the space of states",
                 "scene set to time start section! level direction coordinates fields output"),
    "linearize": ("Prints the derivative of the computed steps: the state transition matrix",
                         "scene set to time start every inertia step arguments output"),
    "lyapunov": ("Prints Lyapunov exponents with error bars: regular, chaotic or undecided",
                 "scene set to time start every count interval seed checkpoint output"),
    "conjugate-points": ("Finds the conjugate points along a geodesic", "request output"),
    "report": ("Runs a scene and writes an HTML page about it, by default report.html: the body turning in space, polhode, rates, "
               "drift beside the estimated error, error against cost, and the scene",
               "scene set to time member tradeoff estimate-error output"),
    "describe": ("Lists the systems, methods and limits of a server", "output"),
}
