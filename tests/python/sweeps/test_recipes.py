"""The recipes of docs/sweeps.md: what they configure is well formed, and says what the page says."""
import ast
import inspect
import re
from pathlib import Path

import stiefel
from stiefel._sweep.axes import COMMON, LISTS

ROOT = Path(__file__).parents[3]
PAGE = (ROOT / "docs/sweeps.md").read_text(encoding="utf-8")


def blocks(language):
    return re.findall(rf"^```{language}\n(.*?)^```", PAGE, re.DOTALL | re.MULTILINE)


def test_programs_call_sweep_with_arguments_that_it_has_and_the_first_one_runs(capsys):
    calls = [node for program in blocks("python") for node in ast.walk(ast.parse(program))
             if isinstance(node, ast.Call) and ast.unparse(node.func) == "stiefel.sweep"]
    assert len(calls) == len(blocks("python"))
    assert {keyword.arg for call in calls for keyword in call.keywords} <= set(inspect.signature(stiefel.sweep).parameters)
    exec(blocks("python")[0], {})
    assert capsys.readouterr().out == "(30, 20)\n"


def test_the_table_of_axes_is_complete():
    listed = set(re.findall(r"`([\w.]+)`", PAGE.split("## Axes")[1].split("\n\n")[1]))
    assert {*LISTS, *COMMON} <= listed
