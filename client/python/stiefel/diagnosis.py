"""The result of `Session.diagnose`: the invariants at a step and their values at step 0."""
from __future__ import annotations

import enum
from dataclasses import dataclass, field
from typing import Optional

from stiefel import v1 as pb
from stiefel.answers import EstimatedError
from stiefel.arrays import Outcome, Price, RunStatus
from stiefel.checksums import verify_diagnosis
from stiefel.replies import complete, ends_at, require


class Conservation(str, enum.Enum):
    """How a method keeps an invariant of the exact motion. Each value equals its name in lower case."""

    EXACT = "exact"  #: kept to rounding, whatever the step
    BOUNDED = "bounded"  #: the error oscillates and does not grow
    DRIFTS = "drifts"  #: the error grows with time
    UNSPECIFIED = "unspecified"  #: the server does not say

    def __str__(self) -> str:
        return self.value

    @staticmethod
    def of(value: int) -> Conservation:
        """Returns the value for a number of the enum on the wire, such as `Client.describe` returns; UNSPECIFIED for an
        unknown number."""
        if value not in pb.Conservation.values():
            return Conservation.UNSPECIFIED
        return Conservation(pb.Conservation.Name(value)[len("CONSERVATION_"):].lower())


@dataclass(frozen=True)
class Invariant:
    """One number that the exact motion keeps."""

    name: str  #: "energy", "spatial_momentum[1,2]", "manakov[3,1]"
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

    @staticmethod
    def of(message: pb.Invariant) -> Invariant:
        return Invariant(message.name, message.initial, message.value, message.drift, message.scale,
                         Conservation.of(message.conservation), message.member if message.HasField("member") else None)


@dataclass(frozen=True)
class Domain:
    """How near the state is to the edge of the map's domain."""

    h_omega: float  #: |h| times the operator norm of Omega
    #: The largest |h| for which a step from this state exists; only for implicit maps and N <= 32.
    largest_step: Optional[float] = None


@dataclass(frozen=True, repr=False)
class Diagnosis:
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
    #: The families of which `invariants` has only those with the largest drifts, and how many invariants each has.
    shortened: dict[str, int] = field(default_factory=dict)
    price: Optional[Price] = field(default=None, compare=False, repr=False)  #: the predicted price of the call

    @property
    def outcome(self) -> Outcome:
        return self.run_status.outcome

    @staticmethod
    def of(message: pb.DiagnoseResponse, request: pb.DiagnoseRequest) -> Diagnosis:
        verify_diagnosis(complete(message, "run_status", "domain", "price"), request.checksum)
        ends_at(message.run_status, message.step, request.to)
        for given, asked in ((message.forms, request.forms), (message.dirac_brackets, request.dirac_brackets)):
            require(len(given) == len(asked), f"{len(given)} values for {len(asked)} forms or brackets")
        require(not request.invariants or bool(message.invariants), "it has no invariants")
        for invariant in message.invariants:
            complete(invariant, "name")
        if request.estimate_error == pb.ERROR_ESTIMATION_ALWAYS:
            complete(message, "estimated_error")
        domain = message.domain
        return Diagnosis(
            message.step, message.time, tuple(map(Invariant.of, message.invariants)),
            message.orthogonality if message.HasField("orthogonality") else None,
            Domain(domain.h_omega, domain.largest_step if domain.HasField("largest_step") else None),
            tuple(message.forms), tuple(message.dirac_brackets),
            message.symplectic_defect if message.HasField("symplectic_defect") else None,
            EstimatedError.of(message.estimated_error) if message.HasField("estimated_error") else None,
            RunStatus.of(message.run_status), message.computed_steps,
            {family.name: family.count for family in message.shortened}, Price.of(message.price))

    def __repr__(self) -> str:
        """Returns at most five lines; `table` has every invariant."""
        lines = [f"<stiefel.Diagnosis {self.outcome} at step {self.step}, time {self.time!r}: {len(self.invariants)} invariants"]
        if self.invariants:
            worst = max(self.invariants, key=lambda invariant: invariant.drift)
            lines.append(f"  largest drift {worst.drift:.1e} of {worst.name}{worst.of_member} ({worst.conservation})")
        if self.orthogonality is not None:
            lines.append(f"  orthogonality {self.orthogonality:.1e}")
        if self.estimated_error is not None:
            lines.append(f"  estimated error: {self.estimated_error}")
        return "\n".join(lines) + ">"

    def table(self) -> str:
        """Returns a table with one line for each invariant, and the estimated error if it was asked for. A drift says
        nothing about that error. In an ensemble a line names the member whose drift of that invariant is the largest."""
        names = [invariant.name + invariant.of_member for invariant in self.invariants]
        width = max(map(len, names), default=0)
        lines = [f"{self.outcome} at step {self.step}, time {self.time!r}"]
        lines += [f"  {name:{width}}  {i.value:< .12g}  drift {i.drift:.1e}  {i.conservation}"
                  for name, i in zip(names, self.invariants)]
        if self.orthogonality is not None:
            of_all = any(i.member is not None for i in self.invariants)
            lines.append(f"  orthogonality {self.orthogonality:.1e}" + ("  the largest of all members" if of_all else ""))
        if self.estimated_error is not None:
            lines.append(f"  estimated error: {self.estimated_error}")
        return "\n".join(lines)
