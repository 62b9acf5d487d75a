"""The properties of a state: invariants with their drifts, the domain of the map, two-forms, the estimated error."""
from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Optional

from stiefel import v1 as pb
from stiefel._results.base import Ended, RunStatus, Word
from stiefel._results.estimate import EstimatedError
from stiefel._results.html import Shown, text_table
from stiefel._results.motion import Motion

__all__ = ["Conservation", "Diagnosis", "Domain", "Invariant"]


class Conservation(Word):
    """How a method keeps an invariant of the exact motion. Each value equals its name in lower case."""

    EXACT = "exact"  #: kept to rounding, whatever the step
    BOUNDED = "bounded"  #: the error oscillates and does not grow
    DRIFTS = "drifts"  #: the error grows with time
    UNSPECIFIED = "unspecified"  #: the server does not say

    @classmethod
    def _missing_(cls, value: object) -> Conservation:
        """A number of the enum on the wire, such as `Client.describe` returns."""
        if isinstance(value, int) and value in pb.Conservation.values():
            return cls(pb.Conservation.Name(value)[len("CONSERVATION_"):].lower())
        return cls.UNSPECIFIED


@dataclass(frozen=True)
class Invariant(Shown):
    """One number that the exact motion keeps."""

    name: str  #: "energy", "spatial_momentum[0,1]", "manakov[3,1]"
    initial: float
    value: float
    #: |value - initial| / scale, computed before the numbers are rounded to doubles or overflow; |value - initial|
    #: where the scale is 0.
    drift: float
    scale: float  #: the size to which the drift is relative
    conservation: Conservation  #: what the method declares that it does to this invariant
    member: Optional[int] = None  #: in an ensemble: the member with the largest drift, whose numbers these are

    @property
    def of_member(self) -> str:
        """" of member 3" in an ensemble, else ""."""
        return "" if self.member is None else f" of member {self.member}"


@dataclass(frozen=True)
class Domain(Shown):
    """How near the state is to the edge of the map's domain."""

    h_omega: float  #: |h| times the operator norm of Omega
    #: The largest |h| for which a step from this state exists; only for implicit maps and N <= 32.
    largest_step: Optional[float] = None


@dataclass(frozen=True, repr=False)
class Diagnosis(Ended):
    """The properties of the state at `step`. What was not asked for or does not exist is None or empty."""

    step: int
    time: float
    invariants: tuple[Invariant, ...]
    orthogonality: Optional[float]  #: max |Q^T Q - I|; None in momentum-only scenes
    domain: Domain
    forms: tuple[float, ...]  #: the values of the requested two-forms, in their order
    dirac_brackets: tuple[float, ...]  #: the values of the requested brackets, in their order
    #: The largest |omega(T phi u, T phi v) - omega(u, v)| / |u||v| over random pairs, where phi is one step.
    symplectic_defect: Optional[float]
    estimated_error: Optional[EstimatedError]
    run_status: RunStatus
    computed_steps: int = field(compare=False, repr=False)
    #: The exact motion from the state at step 0, of a free rigid body in three dimensions; None of another system.
    motion: Optional[Motion] = field(default=None, repr=False)
    #: The families of which `invariants` has only those with the largest drifts, and how many invariants each has.
    shortened: dict[str, int] = field(default_factory=dict)
    work: float = field(default=0.0, compare=False, repr=False)  #: measured instructions

    def __repr__(self) -> str:
        """Returns three lines; `table` has every invariant."""
        text = f"<stiefel.Diagnosis {self.outcome} at step {self.step}, time {self.time!r}: {len(self.invariants)} invariants"
        worst = max(self.invariants, key=lambda invariant: invariant.drift, default=None)
        kept = [f"largest drift {worst.drift:.1e} of {worst.name}{worst.of_member} ({worst.conservation})"] if worst else []
        kept += [] if self.orthogonality is None else [f"orthogonality {self.orthogonality:.1e}"]
        text += f"\n  {', '.join(kept)}" * bool(kept)
        return text + f"\n  estimated error: {self.estimated_error}" * (self.estimated_error is not None) + ">"

    def _as_table(self) -> Any:
        rows = [(i.name + i.of_member, f"{i.value:.12g}", f"{i.drift:.1e}", i.conservation.value) for i in self.invariants]
        if self.orthogonality is not None:
            of_all = any(i.member is not None for i in self.invariants)
            rows.append(("orthogonality" + ", the largest of all members" * of_all, "", f"{self.orthogonality:.1e}", ""))
        return (f"{self.outcome} at step {self.step}, time {self.time!r}; estimated error: {self.estimated_error or 'not asked for'}",
                ("invariant", "value", "drift", "kept"), rows)

    def table(self) -> str:
        """Returns a table with one line for each invariant, and the estimated error if it was asked for. A drift says
        nothing about that error. In an ensemble a line names the member whose drift of that invariant is the largest."""
        return text_table(*self._as_table())
