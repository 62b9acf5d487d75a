"""Sphinx's configuration of the site: the project's own pages, its tutorials and gallery run, and a reference of the Python
package, the commands, the C++ headers and the protocol. `make docs` runs it at the root of the project."""
from __future__ import annotations

import os
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
BUILD = ROOT / "build/release"
sys.path.insert(0, str(BUILD / "python"))
os.environ["PYTHONPATH"] = os.pathsep.join([str(BUILD / "python"), *filter(None, [os.environ.get("PYTHONPATH")])])
os.environ["PATH"] = os.pathsep.join([str(BUILD / "bin"), os.environ["PATH"]])
os.environ.setdefault("STIEFEL_SERVER", str(BUILD / "bin/stiefel-server"))
os.environ["MATPLOTLIBRC"] = str(Path(__file__).with_name("matplotlibrc"))

import stiefel  # noqa: E402

project, author = "stiefel", "The stiefel developers"
version = release = stiefel.__version__
root_doc = "docs/README"
include_patterns = ["*.md", "docs/**", "engine/README.md", "tests/*/README.md"]
exclude_patterns = ["build", "docs/gallery", "docs/site/toctree.md", "docs/site/generated/gallery/*.[!r]*", "**/__pycache__"]
extensions = ["myst_parser", "nbsphinx", "sphinx_gallery.gen_gallery", "sphinx.ext.autodoc", "sphinx.ext.mathjax",
              "sphinxarg.ext", "sphinxcontrib.programoutput"]
suppress_warnings = ["myst.header", "ref.myst", "ref.python"]

myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 4
nbsphinx_execute = "always"
nbsphinx_timeout = 600
sphinx_gallery_conf = {"examples_dirs": "docs/gallery", "gallery_dirs": "docs/site/generated/gallery", "filename_pattern": r"\.py$",
                       "download_all_examples": False, "show_signature": False, "abort_on_example_error": True,
                       "min_reported_time": 1e9}

html_theme, html_title = "furo", f"stiefel {release}"
html_copy_source = html_show_sphinx = html_show_copyright = False
html_extra_path = ["extra"]
highlight_language = "text"

default_role = "literal"  # a word in backticks is code
autodoc_typehints = "signature"
autodoc_member_order = "bysource"
autodoc_default_options = {"members": True, "show-inheritance": True}
autodoc_type_aliases = {"Array": "Array", "SceneLike": "SceneLike"}


def setup(app):
    app.connect("builder-inited", _write_sources)
    app.connect("source-read", _add_toctree)
    app.connect("autodoc-process-docstring", _plain)


def _write_sources(app):
    """Writes a page with the text of every public header, and one with that of every file of the protocol."""
    for name, folders, language in (("cpp", ("engine/include", "client/cpp/include"), "cpp"), ("protocol", ("proto",), "proto")):
        files = [file for folder in folders for file in sorted((ROOT / folder).rglob(f"*.{'h' if language == 'cpp' else 'proto'}"))]
        parts = [f"## {file.name}\n\n```{{literalinclude}} /{file.relative_to(ROOT)}\n:language: {language}\n```\n" for file in files]
        page = ROOT / f"docs/site/generated/{name}.md"
        page.parent.mkdir(exist_ok=True)
        page.write_text("\n".join([f"# {'C++' if name == 'cpp' else 'Protocol'}\n", *parts]), encoding="utf-8")


def _add_toctree(app, name, source):
    """Adds the parts of the site to its first page."""
    if name == root_doc:
        source[0] += "\n" + Path(__file__).with_name("toctree.md").read_text(encoding="utf-8")


def _plain(app, what, name, obj, options, lines):
    """Makes reStructuredText of a plain docstring: indented lines are code, marks of emphasis are themselves."""
    made, code = [], False
    for line in lines:
        indented = line.startswith(" ") and (code or not made or not made[-1].strip())
        if indented and not code:
            made += ["::", ""]
        if code and line and not indented:
            made.append("")
        code = indented or (code and not line)
        made.append(line if code else line.lstrip().replace("*", r"\*").replace("|", r"\|").replace("_ ", r"\_ "))
    lines[:] = made
