"""Lists of names in requests, such as names of fields or invariants."""
from __future__ import annotations

from typing import Iterable, Optional, Union

from stiefel.errors import InvalidArgument, Violation

Names = Union[str, Iterable[str]]


def names(argument: str, given: Optional[Names]) -> list[str]:
    """Returns a list of names; a single text is one name. Raises InvalidArgument for elements that are not texts."""
    if given is None:
        return []
    if isinstance(given, str):
        return [given]
    result = list(given)
    wrong = [Violation(argument, f"{name!r}: must be a name") for name in result if not isinstance(name, str)]
    if wrong:
        raise InvalidArgument(f"{argument}: {wrong[0].description}", tuple(wrong))
    return result
