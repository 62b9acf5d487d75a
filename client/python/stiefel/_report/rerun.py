"""Samples in the viewer of Rerun: a body as a box that turns, a frame as arrows, fields as curves."""
from __future__ import annotations

import math
from typing import Any, Mapping, Optional

import numpy as np

from stiefel._results import body
from stiefel._results.base import Array
from stiefel._results.extras import imported

Batch = Any  # a `stiefel.Batch`

LARGEST = 16  #: curves of a field
SPACING = 2.5  #: between the bodies of an ensemble, whose boxes have a diagonal of 2


def log(batch: Batch, scene: Mapping[str, Any], entity: str, recording: Any) -> None:
    """Does what `Batch.log_to_rerun` says."""
    rerun = imported("rerun", "rerun")
    indexes = [rerun.TimeColumn("step", sequence=batch.step), rerun.TimeColumn("time", duration=batch.time)]
    members = scene.get("members")
    for member in range(members) if members else [None]:
        place = entity if member is None else f"{entity}/{member}"

        def send(name: str, columns: Any) -> None:
            rerun.send_columns(f"{place}/{name}".rstrip("/"), indexes, columns, recording=recording)

        centre = _centre(member or 0, members or 1)
        if body.is_body(batch) and (rotations := body.attitudes(batch, member)) is not None:
            _log_body(rerun, scene, batch, member, rotations, centre, place, send, recording)
        else:
            _log_frame(rerun, batch, member, centre, send)
        for name, values in batch.fields.items():
            flat = body.matrices(values, member).reshape(len(batch), -1)
            flat = np.concatenate([np.real(flat), np.imag(flat)], axis=1) if np.iscomplexobj(flat) else flat
            flat = np.ascontiguousarray(flat[:, :LARGEST], dtype=float)
            send(f"fields/{name}", rerun.Scalars.columns(scalars=flat.ravel()).partition([flat.shape[1]] * len(batch)))


def _centre(member: int, members: int) -> Array:
    """Returns the place of a member on a square grid."""
    side = math.isqrt(members - 1) + 1
    return SPACING * np.array([member % side, member // side, 0.0])


def _log_body(rerun: Any, scene: Mapping[str, Any], batch: Batch, member: Optional[int], rotations: Array, centre: Array,
              place: str, send: Any, recording: Any) -> None:
    inertia = body.principal(scene, member)
    squares = np.maximum(inertia.moments.sum() / 2 - inertia.moments, 0.012 * inertia.moments.sum())
    half = np.sqrt(squares / squares.sum())  # the second moment of mass along an axis is a third of the square
    axes = inertia.axes * np.copysign(1, np.linalg.det(inertia.axes))
    turned = np.einsum("sij,kj->sik", rotations, axes)
    send("body", rerun.Transform3D.columns(translation=np.tile(centre, (len(batch), 1)), mat3x3=turned))
    rerun.log(f"{place}/body/box", rerun.Boxes3D(half_sizes=[half], fill_mode="solid"), static=True, recording=recording)
    arrows = rerun.Arrows3D(vectors=np.diag(half + 0.3), labels=inertia.names,
                            colors=[[0, 114, 178], [213, 94, 0], [0, 158, 115]])
    rerun.log(f"{place}/body/axes", arrows, static=True, recording=recording)
    momenta = body.momenta(scene, batch, member)
    for name, vectors in (("spin_axis", inertia.velocity(momenta)), ("momentum", momenta)):
        in_space = np.einsum("sij,sj->si", rotations, vectors)
        in_space /= np.maximum(np.linalg.norm(in_space, axis=1, keepdims=True), np.finfo(float).tiny)
        send(name, rerun.Arrows3D.columns(vectors=1.4 * in_space, origins=np.tile(centre, (len(batch), 1))))


def _log_frame(rerun: Any, batch: Batch, member: Optional[int], centre: Array, send: Any) -> None:
    """Sends the rows of Q for n < N, else its columns, in their first three coordinates."""
    name = next((name for name in ("Q", "q") if name in batch.fields), None)
    if name is None or np.iscomplexobj(batch.fields[name]):
        return
    values = body.matrices(batch.fields[name], member)
    vectors = values if values.shape[1] < values.shape[2] else values.transpose(0, 2, 1)
    three = np.zeros((*vectors.shape[:2], 3))
    three[:, :, :min(3, vectors.shape[2])] = vectors[:, :, :3]
    count = vectors.shape[1]
    origins = np.tile(centre, (len(batch) * count, 1))
    send("frame", rerun.Arrows3D.columns(vectors=three.reshape(-1, 3), origins=origins).partition([count] * len(batch)))
