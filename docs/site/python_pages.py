"""Makes a page of every public module of the Python package: each class and function by its docstring, by autodoc."""
from __future__ import annotations

import ast
import importlib
import inspect
from pathlib import Path
from types import ModuleType

import stiefel

from text import escaped

_HEAD = """# Python

`import stiefel` gives every name below that begins with `stiefel.` and has one dot.

"""


def modules() -> list[ModuleType]:
    folder = Path(stiefel.__file__).parent
    names = sorted(path.stem for path in folder.glob("*.py") if path.stem not in ("__init__", "version"))
    return [importlib.import_module(f"stiefel.{name}") for name in names]


def names(module: ModuleType) -> list[str]:
    """The public classes and functions that a module defines, in their order, and those that it takes from private modules
    and lists."""
    tree = ast.parse(inspect.getsource(module))
    own = [node.name for node in tree.body if isinstance(node, (ast.ClassDef, ast.FunctionDef)) and not node.name.startswith("_")]
    listed = getattr(module, "__all__", own)
    from_private = [name for name in listed if name not in own and "._" in getattr(getattr(module, name), "__module__", "")]
    return [name for name in own if name in listed] + from_private


def page(module: ModuleType) -> str:
    lines = [f"# {module.__name__}\n", escaped(inspect.getdoc(module) or "") + "\n", "```{eval-rst}"]
    for name in names(module):
        there = "stiefel" if hasattr(stiefel, name) else module.__name__
        kind = "class" if inspect.isclass(getattr(module, name)) else "function"
        kind = "exception" if kind == "class" and issubclass(getattr(module, name), BaseException) else kind
        lines.append(f".. auto{kind}:: {there}.{name}")
    return "\n".join([*lines, "```", ""])


def write(folder: Path) -> None:
    toc = []
    for module in modules():
        if names(module):
            target = module.__name__.replace(".", "_")
            (folder / f"{target}.md").write_text(page(module), encoding="utf-8")
            toc.append(target)
    (folder / "index.md").write_text(_HEAD + "```{toctree}\n:maxdepth: 2\n\n" + "\n".join(toc) + "\n```\n", encoding="utf-8")
