"""Makes a page of every public module of the Python package: each class and function by its docstring, by autodoc."""
from __future__ import annotations

import ast
import importlib
import inspect
from pathlib import Path
from types import ModuleType

import stiefel

from text import paragraphs

_HEAD = """# Python

`import stiefel` gives every name below that begins with `stiefel.` and has one dot.

"""


def modules() -> list[ModuleType]:
    folder = Path(stiefel.__file__).parent
    names = sorted(path.stem for path in folder.glob("*.py") if path.stem not in ("__init__", "_public", "version"))
    return [importlib.import_module(f"stiefel.{name}") for name in names]


def names(module: ModuleType) -> list[str]:
    """The public classes and functions that a module defines, in their order, and those that it takes from private modules
    and lists."""
    tree = ast.parse(inspect.getsource(module))
    own = [node.name for node in tree.body if isinstance(node, (ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)) and not node.name.startswith("_")]
    listed = getattr(module, "__all__", own)
    from_private = [name for name in listed if name not in own and "._" in getattr(getattr(module, name), "__module__", "")]
    return [name for name in own if name in listed] + from_private


def entry(module: ModuleType, name: str) -> str:
    """The directive that documents one name, as a name of `stiefel` where it is one."""
    value = getattr(module, name)
    kind = "function" if inspect.isfunction(value) else "class" if inspect.isclass(value) else "data"
    if inspect.isclass(value) and issubclass(value, BaseException):
        kind = "exception"
    there = "stiefel" if getattr(stiefel, name, None) is value else module.__name__
    return f".. auto{kind}:: {there}.{name}"


def page(module: ModuleType, shown: list[str]) -> str:
    lines = [f"# {module.__name__}\n", paragraphs(inspect.getdoc(module) or ""), "```{eval-rst}"]
    return "\n".join([*lines, *(entry(module, name) for name in shown), "```", ""])


def write(folder: Path) -> None:
    shown: dict[ModuleType, list[str]] = {}
    told: list[int] = []  # what has its entry, by identity: a name may be that of two modules
    for module in sorted(modules(), key=lambda one: one.__name__ == "stiefel.aio"):
        shown[module] = [name for name in names(module) if id(getattr(module, name)) not in told]
        told += [id(getattr(module, name)) for name in shown[module]]
    # What the package takes from private modules.
    own = [name for name in dir(stiefel) if id(getattr(stiefel, name)) not in told and not name.startswith("_")
           and not inspect.ismodule(getattr(stiefel, name))]
    toc = []
    for module, some in {stiefel: own, **shown}.items():
        if some:
            target = module.__name__.replace(".", "_")
            (folder / f"{target}.md").write_text(page(module, some), encoding="utf-8")
            toc.append(target)
    (folder / "index.md").write_text(_HEAD + "```{toctree}\n:maxdepth: 2\n\n" + "\n".join(toc) + "\n```\n", encoding="utf-8")
