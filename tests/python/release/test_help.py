"""What `help` shows: a docstring for everything public."""
import importlib
import inspect
from pathlib import Path

import pytest

import stiefel

MODULES = [importlib.import_module(f"stiefel.{path.stem}") for path in sorted(Path(stiefel.__file__).parent.glob("*.py"))
           if path.stem not in ("__init__", "_public", "version")]


@pytest.mark.parametrize("module", [stiefel, *MODULES], ids=lambda module: module.__name__)
def test_everything_public_has_a_docstring_of_its_own(module):
    assert inspect.getdoc(module)
    for name, value in vars(module).items():
        if name.startswith("_") or not (inspect.isfunction(value) or inspect.isclass(value)) or value.__module__ != module.__name__:
            continue
        assert value.__doc__ and not value.__doc__.startswith(f"{name}("), name  # as `dataclass` writes it
        for member, found in vars(value).items() if inspect.isclass(value) else ():
            found = getattr(found, "__func__", found)
            if not member.startswith("_") and (inspect.isfunction(found) or isinstance(found, property)):
                assert found.__doc__ and len(found.__doc__.split()) >= 3, f"{name}.{member}"
