"""Values as errors show them."""
from __future__ import annotations

import reprlib
from typing import Any

import numpy as np

_MOST = 100  #: characters
_REPR = reprlib.Repr()
# Beyond its limits Repr leaves out the middle of a text, the end of a list. Texts are cut here instead, before that middle.
_REPR.maxstring = _REPR.maxother = _REPR.maxlong = 2 * _MOST + 20


def shown(value: Any) -> str:
    """Returns a value on one line: of a long list the first elements, of a long text its beginning."""
    plain = isinstance(value, np.generic) and value.dtype.kind in "biufc"
    text = " ".join(_REPR.repr(value.item() if plain else value).split())
    return text if len(text) <= _MOST else text[:_MOST - 3] + "..."
