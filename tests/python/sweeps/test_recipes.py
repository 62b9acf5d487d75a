"""The recipes of docs/sweeps.md: what they configure is well formed, and says what the page says."""
import ast
import inspect
import re
import subprocess
from pathlib import Path

import yaml

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


def test_the_recipes_of_clusters_are_well_formed():
    script = blocks("sh")[0]
    subprocess.run(["bash", "-n"], input=script, text=True, check=True)
    example, *arguments = script.split("mpi4py.futures ")[1].split()
    assert all(f'"{option}"' in (ROOT / example).read_text(encoding="utf-8") for option in arguments if option.startswith("--"))
    slurm, dask, ray = map(yaml.safe_load, blocks("yaml"))
    assert slurm["jobqueue"]["slurm"]["cores"] == 8 * 4 and (dask["kind"], ray["kind"]) == ("DaskCluster", "RayCluster")


def test_the_table_of_axes_is_complete():
    listed = set(re.findall(r"`([\w.]+)`", PAGE.split("## Axes")[1].split("\n\n")[1]))
    assert {*LISTS, *COMMON} <= listed
