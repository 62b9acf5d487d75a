"""Packages that only some functions need."""
from __future__ import annotations

import importlib
from contextlib import nullcontext
from types import SimpleNamespace
from typing import Any, Optional


def imported(module: str, extra: str) -> Any:
    """Returns a module. Raises ImportError that names the extra of this package that installs it."""
    try:
        return importlib.import_module(module)
    except ImportError as error:
        package = module.partition(".")[0]
        raise ImportError(f"{package} is needed for this: pip install 'stiefel[{extra}]' ({error})") from error


def progress_bar(count: Optional[int], wanted: bool, unit: str) -> Any:
    """Returns a bar of tqdm for `count` units, None for an unknown number, as a context manager with `update(number)`; one
    that shows nothing if none is wanted."""
    if not wanted:
        return nullcontext(SimpleNamespace(n=0, update=lambda number: None))
    return imported("tqdm", "progress").tqdm(total=count, unit=unit, unit_scale=True)
