"""Makes the page of pictures: runs the script of each, and shows what it draws and how.

A script of docs/gallery takes the file of its picture as its argument; its docstring is the text beside the picture. The
examples of client/examples take a folder.
"""
from __future__ import annotations

import ast
import subprocess
import sys
import tempfile
from pathlib import Path

from text import escaped, fenced

HEAD = """# Gallery

Every picture is drawn by the program below it, which takes the name of the picture's file as its argument, or by the
example that it names.

"""
EXAMPLES = Path(__file__).resolve().parents[2] / "client/examples"
LARGER = {"toutatis": ["toutatis.py"], "tradeoff": ["measure_tradeoff.py", EXAMPLES / "scenes/tradeoff.json"]}


def draw_larger(name: str, picture: Path) -> None:
    """Runs an example and keeps its picture alone."""
    script, *arguments = LARGER[name]
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([sys.executable, EXAMPLES / script, *arguments, "--output", folder], check=True, capture_output=True)
        picture.write_bytes(Path(folder, f"{name}.png").read_bytes())


def draw(script: Path, picture: Path) -> None:
    """Runs a script in the folder of its picture."""
    subprocess.run([sys.executable, script.resolve(), picture.resolve()], check=True, cwd=picture.parent)


def entry(script: Path, picture: str) -> str:
    code = script.read_text(encoding="utf-8")
    tree = ast.parse(code)
    title, _, text = (ast.get_docstring(tree) or "").partition("\n")
    assert isinstance(tree.body[0], ast.Expr) and tree.body[0].end_lineno
    program = "\n".join(code.splitlines()[tree.body[0].end_lineno:]).strip()
    return f"## {escaped(title.rstrip('.'))}\n\n![]({picture})\n\n{escaped(text.strip())}\n\n{fenced(program, 'python')}"


def write(scripts: Path, folder: Path) -> None:
    entries = []
    (folder / "gallery").mkdir(parents=True, exist_ok=True)
    for name, (script, *_) in LARGER.items():
        draw_larger(name, folder / "gallery" / f"{name}.png")
        text = ast.get_docstring(ast.parse((EXAMPLES / script).read_text(encoding="utf-8"))) or ""
        entries.append(f"## {name.capitalize()}\n\n![](gallery/{name}.png)\n\n{escaped(text.splitlines()[0])}\n\n"
                       f"The program is `client/examples/{script}`.\n")
    for script in sorted(scripts.glob("*.py")):
        draw(script, folder / "gallery" / f"{script.stem}.png")
        entries.append(entry(script, f"gallery/{script.stem}.png"))
    (folder / "gallery.md").write_text(HEAD + "\n".join(entries), encoding="utf-8")
