"""The recipes of docs/tangents.md for jax and torch: their gradients are those of differences."""
import contextlib
import importlib.util
import io
import re
from pathlib import Path

import numpy as np
import pytest

PAGE = (Path(__file__).resolve().parents[3] / "docs/tangents.md").read_text(encoding="utf-8").partition("## In an optimiser")[2]
PROGRAM = re.search(r"```python\n(.*?)```", PAGE, re.DOTALL)[1]
RECIPES = {re.match(r"import (\w+)", block)[1]: block for block in re.findall(r"```py\n(.*?)```", PAGE, re.DOTALL)}


def printed(program, names):
    with contextlib.redirect_stdout(io.StringIO()) as out:
        exec(program, names)
    return np.array([float(number) for number in re.findall(r"-?\d[\d.e+-]*", out.getvalue())])


@pytest.fixture(scope="module")
def recipe(client):
    """The names of the program, the gradient that it prints, and that of differences."""
    names = {}
    gradient = printed(PROGRAM, names)
    h = 1e-5 * np.eye(3)
    loss = lambda omega: ((names["turned"](omega)[0] - names["wanted"])**2).sum()  # noqa: E731
    yield names, gradient, [(loss(names["omega"] + d) - loss(names["omega"] - d)) / 2e-5 for d in h]
    names["client"].close()


def test_the_gradient_is_that_of_differences(recipe):
    np.testing.assert_allclose(recipe[1], recipe[2], rtol=1e-6, atol=1e-7)


@pytest.mark.parametrize("package", ["jax", "torch"])
def test_a_recipe_gives_it_too(recipe, package):
    if importlib.util.find_spec(package) is None:
        pytest.skip(f"{package} is not installed; it comes from PyPI")
    np.testing.assert_allclose(printed(RECIPES[package], recipe[0]), recipe[2], rtol=1e-6, atol=1e-7)
