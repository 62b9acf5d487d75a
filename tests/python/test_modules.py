"""The package's modules: which are public, what is imported when, and what completion shows."""
import importlib
import inspect
import re
import subprocess
import sys
from pathlib import Path

import pytest

import stiefel

FOLDER = Path(stiefel.__file__).parent
PUBLIC = {"aio", "errors", "manifold", "results", "simulation", "solids"}


def test_the_public_modules():
    there = {path.stem for path in FOLDER.glob("*.py") if not path.stem.startswith("_")} - {"version"}
    folders = {path.name for path in FOLDER.iterdir() if path.is_dir() and path.name != "__pycache__"}
    assert there == PUBLIC and {name for name in folders if not name.startswith("_")} == {"cli", "v1"}
    assert all(hasattr(stiefel, name) for name in dir(stiefel))
    public = {name for name, value in vars(stiefel).items() if not name.startswith("_") and not inspect.ismodule(value)}
    assert public - {"Any", "annotations"} == set(dir(stiefel)) - {"__version__", "solids"}


def test_nothing_is_imported_before_it_is_used():
    """The command needs neither numpy nor gRPC to say what is wrong with its arguments."""
    for program in ("import stiefel", "from stiefel.cli import main; main(['run', '--too'])", "from stiefel.cli import main; main(['--help'])"):
        program += "; import sys; sys.exit(bool({'numpy', 'grpc', 'google', 'matplotlib', 'xarray'} & {*sys.modules}))"
        assert subprocess.run([sys.executable, "-c", program], capture_output=True).returncode == 0


@pytest.mark.parametrize("first", ["stiefel._sweep.worker", "stiefel._report.rerun", "stiefel.results", "stiefel.errors"])
def test_a_name_is_the_same_whatever_was_imported_first(first):
    program = f"import {first}, stiefel; assert callable(stiefel.sweep) and callable(stiefel.rerun) and 'toutatis' in stiefel.examples"
    subprocess.run([sys.executable, "-c", program], check=True)


@pytest.mark.parametrize("name", sorted(PUBLIC))
def test_completion_shows_of_a_module_what_is_public(name):
    module = importlib.import_module(f"stiefel.{name}")
    shown = dir(module)
    assert shown == sorted(module.__all__) and shown and not any(one.startswith("_") for one in shown)
    assert all(not inspect.ismodule(getattr(module, one)) for one in shown)
    defined = {one for one, value in vars(module).items() if inspect.isclass(value) and value.__module__ == module.__name__}
    assert {one for one in defined if not one.startswith("_")} <= set(shown), "a class without an underscore is public"


def test_an_optional_package_belongs_to_an_extra():
    """What an error tells the user to install exists."""
    extras = (FOLDER.parent / "pyproject.toml").read_text(encoding="utf-8").partition("[project.optional-dependencies]")[2]
    named = [found for file in FOLDER.rglob("*.py")
             for found in re.findall(r'imported\("([a-z0-9]+)[\w.]*", "(\w+)"\)', file.read_text(encoding="utf-8"))]
    assert len(named) > 8
    for module, extra in named:
        line = re.search(rf"^{extra} = .*$", extras, re.MULTILINE)
        assert line and {"distributed": "distributed", "rerun": "rerun-sdk"}.get(module, module) in line[0], (module, extra)
