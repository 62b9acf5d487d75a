"""Packages that only some functions need."""
from __future__ import annotations

import importlib
from typing import Any


def imported(module: str, extra: str) -> Any:
    """Returns a module. Raises ImportError that names the extra of this package that installs it."""
    try:
        return importlib.import_module(module)
    except ImportError as error:
        package = module.partition(".")[0]
        raise ImportError(f"{package} is needed for this: pip install 'stiefel[{extra}]' ({error})") from error
