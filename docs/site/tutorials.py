"""Runs the tutorials, which are notebooks, and makes a page of each with what its cells print and draw."""
from __future__ import annotations

import base64
import os
import re
from pathlib import Path

import nbformat
from nbclient import NotebookClient
from nbclient.exceptions import CellExecutionError

from text import fenced

COLOUR = re.compile(r"\x1b\[[0-9;]*m")


def executed(notebook: Path) -> nbformat.NotebookNode:
    """Runs a notebook in its folder. Raises RuntimeError with the cell that failed and its error."""
    os.environ["PYDEVD_DISABLE_FILE_VALIDATION"] = "1"  # of which the kernel's debugger warns
    os.environ["MPLBACKEND"] = "module://matplotlib_inline.backend_inline"
    os.environ["MATPLOTLIBRC"] = str(Path(__file__).with_name("matplotlibrc"))
    made = nbformat.read(notebook, as_version=4)
    client = NotebookClient(made, timeout=600, kernel_name="python3", resources={"metadata": {"path": str(notebook.parent)}})
    try:
        client.execute()
    except CellExecutionError as error:
        raise RuntimeError(f"{notebook.name}: {COLOUR.sub('', str(error))}") from None
    return made


def outputs(cell: nbformat.NotebookNode, folder: Path, name: str) -> str:
    """What a cell printed and returned, as Markdown. Pictures are written to `folder`."""
    parts = []
    for i, output in enumerate(cell.outputs):
        data = output.get("data", {})
        if "image/png" in data:
            picture = f"{name}-{cell.execution_count}-{i}.png"
            (folder / picture).write_bytes(base64.b64decode(data["image/png"]))
            parts.append(f"![]({picture})\n")
        elif "text/plain" in data or output.output_type == "stream":
            parts.append(fenced(COLOUR.sub("", output.get("text") or data["text/plain"])))
    return "\n".join(parts)


def page(notebook: nbformat.NotebookNode, folder: Path, name: str) -> str:
    parts = []
    for cell in notebook.cells:
        if cell.cell_type == "code":
            parts += [fenced(cell.source, "python"), outputs(cell, folder, name)]
        else:
            parts.append(cell.source + "\n")
    return "\n".join(parts)


def write(tutorials: Path, folder: Path) -> None:
    for notebook in sorted(tutorials.glob("*.ipynb")):
        text = page(executed(notebook), folder, notebook.stem)
        (folder / f"{notebook.stem}.md").write_text(text, encoding="utf-8")
