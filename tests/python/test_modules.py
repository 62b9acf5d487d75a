"""The package's modules: which are public, that no imports form a circle, and what completion shows."""
import ast
import dataclasses
import enum
import importlib
import inspect
import re
import subprocess
import sys
from pathlib import Path

import pytest

import stiefel

FOLDER = Path(stiefel.__file__).parent
PUBLIC = {"aio", "client", "errors", "manifold", "results", "scene", "server", "session", "simulation", "solids"}


def sources(folder):
    """The syntax trees of a package's modules by their names, without the generated ones."""
    return {".".join(("stiefel", *path.relative_to(folder).with_suffix("").parts)).removesuffix(".__init__"): ast.parse(path.read_text())
            for path in folder.rglob("*.py") if not path.name.endswith(("_pb2.py", "_pb2_grpc.py"))}


def arrows(trees):
    """The modules that each module imports, wherever in it."""
    found = {}
    for name, tree in trees.items():
        imports = [node for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)]
        named = {f"{node.module}.{one.name}" for node in imports for one in node.names} | {node.module for node in imports}
        named |= {one.name for node in ast.walk(tree) if isinstance(node, ast.Import) for one in node.names}
        found[name] = (named & set(trees)) - {name, "stiefel"}
    return found


def circle(arrows):
    """Some modules that import each other, none if there are none."""
    left = dict(arrows)
    while free := [name for name, to in left.items() if not to & set(left)]:
        for name in free:
            del left[name]
    return sorted(left)


def test_no_imports_form_a_circle():
    trees = sources(FOLDER)
    assert len(trees) > 40 and circle(arrows(trees)) == []
    for name, tree in trees.items():
        assert not any(isinstance(node, ast.Name) and node.id == "TYPE_CHECKING" for node in ast.walk(tree)), name


def test_the_public_modules():
    there = {path.stem for path in FOLDER.glob("*.py") if not path.stem.startswith("_")} - {"version"}
    folders = {path.name for path in FOLDER.iterdir() if path.is_dir() and path.name != "__pycache__"}
    assert there == PUBLIC and {name for name in folders if not name.startswith("_")} == {"cli", "v1"}
    assert set(stiefel.__all__) < set(dir(stiefel)) and all(hasattr(stiefel, name) for name in dir(stiefel))
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


@pytest.mark.parametrize("kind", [getattr(stiefel, name) for name in dir(stiefel) if inspect.isclass(getattr(stiefel, name))],
                         ids=lambda kind: kind.__name__)
def test_what_completion_shows_of_a_class_is_documented(kind):
    fields = {field.name for field in dataclasses.fields(kind)} if dataclasses.is_dataclass(kind) else set()
    told = set(kind.__annotations__) | set(getattr(stiefel.StiefelError, "__annotations__", ())) | fields
    for name in dir(kind):
        if name.startswith("_") or name in told or hasattr(OSError, name) or hasattr(str, name) and issubclass(kind, enum.Enum):
            continue
        value = inspect.getattr_static(kind, name)
        assert inspect.getdoc(getattr(value, "fget", None) or value) or isinstance(value, (enum.Enum, int)), f"{kind.__name__}.{name}"
        assert not isinstance(value, staticmethod), f"{kind.__name__}.{name}"


def test_what_completion_shows_of_an_object(client):
    """The names of its class, which the test above reads, and these attributes."""
    with client.create({"system": "rigid_body", "step": 0.1, "body": {"moments": [1, 2, 3], "angular_velocity": [1, 0, 1]}}) as session:
        more = {kind: {name for name in set(dir(one)) - set(dir(kind)) if not name.startswith("_")}
                for one in (client, session, session.drive()) for kind in [type(one)]}
    assert list(more.values()) == [{"address"}, {"created", "epoch", "message"}, set()]


def test_an_optional_package_belongs_to_an_extra():
    """What an error tells the user to install exists."""
    extras = (FOLDER.parent / "pyproject.toml").read_text(encoding="utf-8").partition("[project.optional-dependencies]")[2]
    named = [found for file in FOLDER.rglob("*.py")
             for found in re.findall(r'imported\("([a-z0-9]+)[\w.]*", "(\w+)"\)', file.read_text(encoding="utf-8"))]
    assert len(named) > 8
    for module, extra in named:
        line = re.search(rf"^{extra} = .*$", extras, re.MULTILINE)
        assert line and {"distributed": "distributed", "rerun": "rerun-sdk"}.get(module, module) in line[0], (module, extra)
