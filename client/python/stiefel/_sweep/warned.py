"""The warnings of servers about points of a sweep, joined so that each kind comes once."""
from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

# "member 1: TEXT (2 members have a warning like this)", in which both additions may be absent.
_WARNING = re.compile(r"(?:member (\d+): )?(.*?)(?: \((\d+) members have a warning like this\))?", re.DOTALL)


@dataclass
class Warned:
    """The warnings of all chunks."""

    known: Collection[str] = ()  #: texts that need not be told again
    _found: dict[str, tuple[int, str, int]] = field(default_factory=dict)  # by kind: the first point, its text, how many

    def take(self, points: NDArray[np.int64], warnings: Iterable[str]) -> None:
        """Adds the warnings about an ensemble of these points."""
        for warning in warnings:
            member, text, count = _WARNING.fullmatch(warning).groups()  # type: ignore[union-attr]
            kind = text.rpartition(": ")[2]
            point, first = int(points[int(member or 0)]), self._found.get(kind)
            total = int(count or 1) + (first[2] if first else 0)
            earlier = first if first and first[0] < point else (point, text)
            self._found[kind] = (earlier[0], earlier[1], total)

    def texts(self) -> Iterator[str]:
        """Yields one text for each kind, with its first point and with how many points have it."""
        for point, text, count in self._found.values():
            if text not in self.known:
                more = f" ({count} points have a warning like this)" if count > 1 else ""
                yield f"point {point}: {text}{more}"
