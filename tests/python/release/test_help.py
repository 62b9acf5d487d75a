"""What `help` shows: a page that can be read, and a docstring for everything public that stands alone."""
import dataclasses
import enum
import importlib
import inspect
import pydoc
import re
from pathlib import Path

import pytest

import stiefel

MODULES = [importlib.import_module(f"stiefel.{path.stem}") for path in sorted(Path(stiefel.__file__).parent.glob("*.py"))
           if path.stem not in ("__init__", "_public", "version")]


def defined(module):
    """The public functions and classes that a module defines."""
    return {name: value for name, value in vars(module).items() if not name.startswith("_")
            and (inspect.isfunction(value) or inspect.isclass(value)) and value.__module__ == module.__name__}


def documented():
    """Everything public with its docstring: modules, functions, classes, and what the classes define themselves."""
    for module in [stiefel, *MODULES]:
        yield module.__name__, inspect.getdoc(module)
        for name, value in defined(module).items():
            yield f"{module.__name__}.{name}", value.__doc__
            for member, found in vars(value).items() if inspect.isclass(value) else ():
                found = getattr(found, "__func__", found)
                if not member.startswith("_") and (inspect.isfunction(found) or isinstance(found, property)):
                    yield f"{module.__name__}.{name}.{member}", found.__doc__


def test_help_of_the_package_can_be_read(monkeypatch):
    if hasattr(inspect.Signature, "format"):  # Python 3.13 gives every argument of a signature a line
        one_line = inspect.Signature.format
        monkeypatch.setattr(inspect.Signature, "format", lambda signature, **_: one_line(signature))
    text = pydoc.plain(pydoc.render_doc(stiefel))
    assert len(text.splitlines()) < 800
    for name in ("simulate", "class Client", "class Session", "sweep", "examples"):
        assert name in text


@pytest.mark.parametrize("name, text", documented(), ids=lambda value: value if "stiefel" in str(value)[:8] else "")
def test_it_has_a_docstring_that_stands_alone(name, text):
    """It says something by itself: it is not made by `dataclass`, begins with a capital and ends as a sentence does."""
    assert text and not re.match(r"\w+\(.*\)$", text.strip()), name
    first = text.strip().split("\n\n")[0]
    assert re.match(r'[A-Z|`"]', first) and first.rstrip().endswith((".", ":", ")")) and len(first.split()) >= 3, first
    assert not re.match(r"(The same|Likewise|See |As `|Also )", first), first


@pytest.mark.parametrize("name", sorted(dir(stiefel)))
def test_help_of_every_name_says_something(name):
    value = getattr(stiefel, name)
    if inspect.isclass(value) and not issubclass(value, (enum.Enum, dict)):
        assert value.__doc__ and value.__doc__ not in (object.__doc__, Exception.__doc__), name
        assert not dataclasses.is_dataclass(value) or not value.__doc__.startswith(f"{name}(")
