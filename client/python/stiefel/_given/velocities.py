"""Velocities in an initial state, instead of the block that a system has: Omega of a body in N dimensions, Q' of a frame."""
from __future__ import annotations

from typing import Any, Mapping

import numpy as np
from numpy.typing import NDArray

from stiefel._given.numbers import refused

_LEFT = ("rigid_body", "symmetric_rigid_body", "reduced_rigid_body", "mclachlan_scovel")
_RIGHT = ("right_rigid_body", "right_symmetric_rigid_body")
#: The block of each system on V(n, N) that says how the frame moves.
_FRAMES = {"stiefel": "S", "stiefel_costate": "P", "stiefel_momentum": "M"}
MOMENTA = ("M", "P", "S", "B")  #: the blocks of which a velocity takes the place


def with_momenta(system: Any, blocks: Mapping[str, Any], inertia: Any) -> Mapping[str, Any]:
    """Returns the blocks of an initial state, in which M = Lambda Omega + Omega Lambda stands for Omega, where Q' = Q Omega
    (Q' = Omega Q in the right-invariant systems), and S = Q' Lambda, P = S or M = Q^T S - S^T Q for Qdot on V(n, N)."""
    given = [name for name in ("Omega", "Qdot") if name in blocks]
    takes = ("Omega", "Qdot") if system in _LEFT + _RIGHT else ("Qdot",) if system in _FRAMES else ()
    if not given:
        return blocks
    path = f"scene.initial.{given[0]}"
    if given[0] not in takes:
        raise refused(path, f"must be absent: {system} takes {' or '.join(takes) or 'neither Omega nor Qdot'}")
    if (others := [*given[1:], *(name for name in MOMENTA if name in blocks)]):
        raise refused(path, f"must be absent where {others[0]} is given")
    velocity = blocks[given[0]]
    scale = np.asarray(inertia if inertia is not None else [], float)
    if inertia is None:
        raise refused("scene.inertia", f"absent: must be given where {given[0]} is, one number for each column")
    if isinstance(velocity, Mapping):
        raise refused(path, "must be a matrix of real numbers")
    if scale.shape[-1:] != velocity.shape[-1:] or scale.ndim > 2:
        turned = scale.shape[-1:] == velocity.shape[-2:-1] and velocity.shape[-1] < velocity.shape[-2]
        raise refused(path, f"the shape {velocity.shape}: must have as many columns as inertia has numbers, {scale.shape[-1]}"
                            + "; it looks transposed: frames have their vectors as rows" * turned)
    _check(path, given[0], velocity)
    rest = {name: block for name, block in blocks.items() if name not in given}
    Lambda = scale[..., np.newaxis, :]
    if system in _FRAMES:
        S = velocity * Lambda
        name = _FRAMES[system]
        return {**rest, name: _momentum_of(path, rest, S) if name == "M" else S}
    Omega = velocity
    if given[0] == "Qdot":
        Q = _frame(path, rest, velocity)
        Omega = velocity @ _T(Q) if system in _RIGHT else _T(Q) @ velocity
    return {**rest, "M": np.swapaxes(Lambda, -1, -2) * Omega + Omega * Lambda}


def _check(path: str, name: str, velocity: NDArray[Any]) -> None:
    """An Omega that is not skew is refused under its own name, not as a momentum that is not."""
    defect = np.max(np.abs(velocity + _T(velocity)), initial=0.0) if name == "Omega" and velocity.shape[-1] == velocity.shape[-2] else 0.0
    if defect > 0.01 * np.max(np.abs(velocity), initial=0.0):
        raise refused(path, f"max |Omega + Omega^T| = {defect:.3g}: must be skew-symmetric")


def _momentum_of(path: str, blocks: Mapping[str, Any], S: NDArray[Any]) -> NDArray[Any]:
    Q = _frame(path, blocks, S)
    return np.asarray(_T(Q) @ S - _T(S) @ Q)


def _frame(path: str, blocks: Mapping[str, Any], velocity: NDArray[Any]) -> NDArray[Any]:
    Q = blocks.get("Q")
    if not isinstance(Q, np.ndarray) or Q.shape != velocity.shape:
        raise refused(path, f"the shape {velocity.shape}: must be that of the matrix Q")
    return Q


def _T(matrix: NDArray[Any]) -> NDArray[Any]:
    return np.swapaxes(matrix, -1, -2)
