"""What a command line gives: scenes with their changes, files of arguments, and where the fields of an error were written."""
from __future__ import annotations

import argparse
import inspect
import json
import math
import re
import sys
from pathlib import Path
from typing import Any, Callable, Iterator, Optional

from stiefel.cli.options import names
from stiefel.errors import StiefelError
from stiefel._scene import parse_json, read

_OPTIONS = {"to": "system", "address": "server"}  #: the options of arguments of another name, where there is none of the same
_HINTS = {"`times` of Session.trajectory": "--times of stiefel run", "Session.step and Session.trajectory take any time":
          "stiefel run takes any time", "`tls`": "--tls", "`token`": "--token-file",
          "normalize=True": "--set normalize=true", "tls: ca: ": "--tls: "}


class BadInput(Exception):
    """Input that the user has to change."""


def mapping(file: str) -> dict[str, Any]:
    """Reads an example, a JSON file or, for "-", stdin."""
    return dict(parse_json("stdin", sys.stdin.buffer.read()) if file == "-" else read(file))


def scene(given: argparse.Namespace) -> dict[str, Any]:
    """Returns the scene with the changes of --set."""
    found = mapping(given.scene)
    for text in given.changes:
        _change(found, text)
    return found


def _change(scene: dict[str, Any], text: str) -> None:
    """Sets the field at a path such as "body.moments"; null removes it."""
    path, equals, value = text.partition("=")
    if not path or not value:
        raise BadInput(f"--set: {text}: must be FIELD=VALUE, such as body.angular_velocity=0.1,1,0.2")
    *parents, name = path.split(".")
    place = scene
    for parent in parents:
        inner = place.get(parent)
        place[parent] = place = {} if inner is None else dict(inner) if isinstance(inner, dict) else inner
        if not isinstance(place, dict):
            raise BadInput(f"--set: {text}: {parent} is no object and has no {name}")
    place[name] = _value(value)
    if place[name] is None:
        del place[name]


def _value(text: str) -> Any:
    """Returns JSON, a list of numbers or texts separated by commas, or the text."""
    try:
        return json.loads(text)
    except ValueError:
        return [_value(part) for part in names(text)] if "," in text else text


def times(file: str) -> list[float]:
    """Reads times that white space separates."""
    found: list[float] = []
    for word in Path(file).read_text(encoding="utf-8-sig").split():
        try:
            found.append(float(word))
        except ValueError:
            found.append(math.nan)
        if not math.isfinite(found[-1]):
            raise BadInput(f"--times[{len(found) - 1}]: {word}: must be a finite number")
    if not found:
        raise BadInput(f"--times: {file} has no times")
    return found


def arguments(given: argparse.Namespace, function: Callable[..., Any]) -> dict[str, Any]:
    """Returns the arguments of a function that options of its names give."""
    taken = inspect.signature(function).parameters
    return {name: value for name, value in vars(given).items() if name in taken and value is not None}


def request(file: Optional[str], *functions: Callable[..., Any]) -> dict[str, Any]:
    """Reads more arguments of one of the functions from a file. Raises BadInput for names that none of them has."""
    found = {} if file is None else mapping(file)
    known = [name for function in functions for name in inspect.signature(function).parameters if name not in ("self", "timeout")]
    for name in found:
        if name not in known:
            raise BadInput(f"{file}: {name}: unknown argument; it may be {', '.join(dict.fromkeys(known))}")
    return found


def faults(error: StiefelError, given: argparse.Namespace) -> Iterator[str]:
    """Yields the lines of an error, which name what the user wrote: files and options."""
    told = [f"{_place(one.field, given)}{one.description}" for one in error.violations] or [error.message]
    for line in told:
        for theirs, ours in _HINTS.items():
            line = line.replace(theirs, ours)
        yield line


def _place(field: str, given: argparse.Namespace) -> str:
    """Returns where a field was written: "scene.json: initial.Q: " for "scene.initial.Q", "--fields[1]: " for "fields[1]"."""
    name, rest = re.match(r"(\w*)(.*)", field).groups()  # type: ignore[union-attr]
    file = getattr(given, "scene", None)
    shown = "stdin" if file == "-" else file
    option = name if hasattr(given, name) else _OPTIONS.get(name, name)
    if name == "scene" and file:
        return f"{shown}: {rest[1:]}: " if rest else ""
    asked = getattr(given, "arguments", getattr(given, "request", None))
    if getattr(given, option, None) is not None and option != "scene":
        return f"--{option.replace('_', '-')}{rest}: "
    return f"{asked}: {field}: " if asked else f"{field}: "
