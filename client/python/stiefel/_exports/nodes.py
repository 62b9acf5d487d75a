"""The attitudes that an export writes, and what a reader loses by rounding and interpolation."""
from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any, Optional

import numpy as np
from numpy.typing import NDArray

from stiefel._exports.interpolation import interpolation_error, rates_of
from stiefel._given.instants import Instant, instant
from stiefel._results.attitude import is_right, quaternions
from stiefel._results.html import Shown

Trajectory = Any  # a `stiefel.Trajectory`


@dataclass(frozen=True, repr=False)
class Export(Shown):
    """What was written, and how far from it a reader may be."""

    files: tuple[str, ...]
    format: str
    samples: int
    time_rounding: float  #: the largest difference between the time of a sample and that in the file, in seconds
    #: The largest angle in radians, by an estimate from above, between the motion and the shortest turn from one sample to
    #: the next; NaN where it is not known: a single sample, or two of a trajectory that does not know its scene.
    interpolation_error: float

    def __repr__(self) -> str:
        rounding = "exact" if self.time_rounding == 0 else f"rounded by at most {self.time_rounding:.1e} s"
        between = "" if np.isnan(self.interpolation_error) else \
            f"; between two samples at most {self.interpolation_error:.1e} rad from the motion"
        count = f"{self.samples} sample{'s' if self.samples != 1 else ''}"
        return f"<stiefel.Export of {count} as {self.format}: {', '.join(self.files)}\n  times {rounding}{between}>"


@dataclass(frozen=True)
class Nodes:
    """Samples in the order of time."""

    time: NDArray[np.float64]  #: seconds after the epoch
    quaternion: NDArray[np.float64]  #: w, x, y, z, body to space, with a continuous sign
    body_rate: Optional[NDArray[np.float64]]  #: in body axes; None if neither the fields nor the scene tell it
    epoch: Instant
    scene: Optional[Any] = None  #: resolved, None if it is not known

    @property
    def space_rate(self) -> Optional[NDArray[np.float64]]:
        """The angular velocity in space axes."""
        if self.body_rate is None:
            return None
        w, v = self.quaternion[:, :1], self.quaternion[:, 1:]
        return np.asarray(self.body_rate + 2 * np.cross(v, np.cross(v, self.body_rate) + w * self.body_rate))

    def instants(self) -> list[Instant]:
        return [self.epoch.after(float(time)) for time in self.time]

    def interpolation_error(self) -> float:
        """Returns an upper estimate of the largest angle between the motion and the shortest turns from sample to sample."""
        return interpolation_error(self.time, self.quaternion, self.body_rate, self.scene)


def nodes_of(run: Trajectory, epoch: Any = None) -> Nodes:
    """Returns the samples of a trajectory. `epoch`: the instant of time 0 if the scene has none. Raises ValueError if there
    is no attitude, no epoch, or an ensemble."""
    given = run.epoch if epoch is None else epoch
    if given is None:
        raise ValueError("epoch: absent: give the instant of time 0, here or as `epoch` of the scene")
    order = np.argsort(run.time, kind="stable")
    order = order[np.r_[True, np.diff(run.time[order]) > 0]] if len(order) else order
    q = quaternions(run.fields, run._system)
    if q.ndim != 2:
        raise ValueError(f"the attitudes of an ensemble have the shape {q.shape}: an export takes one motion, such as that of run.member(0)")
    q = q[order]
    if not len(q):
        raise ValueError("the trajectory has no samples")
    flips = np.cumprod(np.where((q[1:] * q[:-1]).sum(axis=1) < 0, -1, 1))
    q[1:] *= flips[:, None]
    rate = run.fields.get("angular_velocity")
    if rate is None and "Omega" in run.fields:
        Omega = run.fields["Omega"]
        rate = np.stack([Omega[:, 2, 1], Omega[:, 0, 2], Omega[:, 1, 0]], axis=1) * (-1 if is_right(run._system) else 1)
    scene = None if run.origin is None else run.scene
    return Nodes(run.time[order], q, rates_of(q, scene) if rate is None else np.asarray(rate, float)[order],
                 instant("epoch", given), scene)


def written(path: "str | os.PathLike[str]", text: str) -> str:
    """Writes a file, which appears under its name only when it is complete."""
    path = os.fspath(path)
    part = path + ".part"
    with open(part, "w", encoding="ascii", newline="\n") as out:
        out.write(text)
    os.replace(part, path)
    return path
