"""What a server offers, and the method that it chose."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from stiefel import v1 as pb
from stiefel._results.html import Shown

__all__ = ["Catalogue", "Choice"]


class Catalogue(Shown):
    """The systems and methods of a server, with its limits and versions: the fields of stiefel.v1.DescribeResponse, such as
    `systems`, `methods`, `limits`, `version`, `numerics_id` and `build`."""

    def __init__(self, message: pb.DescribeResponse):
        self._message = message

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        return getattr(self._message, name)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Catalogue) and bool(self._message == other._message)

    __hash__ = None  # type: ignore[assignment]

    def _as_table(self) -> Any:
        return (f"stiefel-server {self.version}, numerics id {self.numerics_id}", ("system", "fields", "summary"),
                [(one.name, ", ".join(field.name for field in one.fields), one.summary) for one in self.systems])

    def __repr__(self) -> str:
        systems, methods = (", ".join(one.name for one in those) for those in (self.systems, self.methods))
        return f"<stiefel.Catalogue of version {self.version}\n  systems {systems}\n  methods {methods}>"


@dataclass(frozen=True, repr=False)
class Choice(Shown):
    """A method that the server chose for a scene's tolerance."""

    method: dict[str, Any]  #: the value of "method" in a scene
    tolerance: float
    horizon: float
    reason: str  #: one sentence with error, work, what was measured and which reference it was compared with
    error: float  #: largest error of attitude and momentum up to the horizon, at every step; of `exact` at some of very many

    def __repr__(self) -> str:
        method = ", ".join(f"{name} {value}" if name != "name" else str(value) for name, value in self.method.items())
        return f"<stiefel.Choice of {method} for the tolerance {self.tolerance:g} up to time {self.horizon:g}: {self.reason}>"
