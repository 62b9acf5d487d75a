"""Sphinx's configuration of the site; build_site.py writes the sources that it reads."""
import os
import sys

sys.path.insert(0, os.environ["SITE_PACKAGE"])

project = "stiefel"
author = "The stiefel developers"
version = release = os.environ["SITE_VERSION"]
root_doc = "index"
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.mathjax"]
exclude_patterns = ["files"]

myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 4
# Pages that begin a part below the level of the part before it; Client, which is also a name of stiefel.aio.
suppress_warnings = ["myst.header", "ref.python"]

html_theme = "furo"
html_title = f"stiefel {release}"
html_copy_source = False
html_show_sphinx = html_show_copyright = False
highlight_language = "text"

# Docstrings are plain text in which a word in backticks is code.
default_role = "literal"
autodoc_typehints = "signature"
autodoc_member_order = "bysource"
autodoc_default_options = {"members": True, "show-inheritance": True}
autodoc_type_aliases = {"Array": "Array", "SceneLike": "SceneLike"}


def setup(app):
    app.connect("autodoc-process-docstring", _plain)


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
