"""Bodies in three dimensions from what people have: tensors or solids, attitudes in any form, angular velocity or momentum in body
or space axes, rates of Euler angles."""
from __future__ import annotations

from typing import Any, Mapping, Optional, Union

import numpy as np
from numpy.typing import NDArray

from stiefel import _rotations
from stiefel import v1 as pb
from stiefel._given.attitudes import ORDERS, of_any, of_euler, of_mrp
from stiefel._given.instants import epoch_text
from stiefel._given.mappings import Walk
from stiefel._given.numbers import refused
from stiefel._given.shapes import of_symmetric
from stiefel._given.shown import shown
from stiefel._given.typed import Method, MethodName, Scene, SystemName
from stiefel.errors import InvalidArgument

_FIELDS = tuple(field.name for field in pb.Body.DESCRIPTOR.fields)
#: Names of which a body has one of each group: what a new one takes the place of.
_GROUPS = (("moments", "inertia_tensor"), ("attitude", "mrp", "euler_angles"), ("angular_velocity", "angular_momentum", "euler_rates"))
#: What says how a list is meant, the choices, and the lists.
_MEANINGS = (("order", ORDERS, ("attitude",)), ("frame", ("body", "space"), ("angular_velocity", "angular_momentum")),
             ("sequence", (), ("euler_angles",)), ("euler_rates", (), ("euler_angles",)))
_PLACES = ((0, 3, 4), (3, 1, 5), (4, 5, 2))  #: of the matrix entries in Ixx, Iyy, Izz, Ixy, Ixz, Iyz


def body_scene(*, moments: Any = None, inertia_tensor: Any = None, attitude: Any = None, order: str = "wxyz", mrp: Any = None,
               euler_angles: Any = None, sequence: Optional[str] = None, angular_velocity: Any = None, angular_momentum: Any = None,
               frame: Optional[str] = None, euler_rates: Any = None, normalize: bool = False, system: SystemName = "rigid_body",
               step: Any = None, epoch: Any = None, horizon: Any = None, method: Union[Method, MethodName, None] = None,
               tolerance: Any = None, members: Optional[int] = None) -> Scene:
    """Returns the scene of a rigid body in three dimensions, in SI units and with the attitude from body to space axes.

    Inertia: `moments` about the body's axes, or `inertia_tensor`, a symmetric 3 x 3 matrix, the six numbers Ixx, Iyy, Izz,
    Ixy, Ixz, Iyz of that matrix, a `Solid` or a list of solids, in an ensemble also a list of these lists. Attitude:
    `attitude`, a quaternion in the `order` "wxyz" or "xyzw" (scipy, SPICE kernels of many tools and ROS write the
    scalar last), a rotation matrix whose columns are the body axes in space, or a Rotation of scipy; or `mrp`, modified
    Rodrigues parameters; or `euler_angles` in radians with their `sequence`, as scipy has it: "ZXZ" about the axes that turn
    with the body, "zxz" about fixed axes; by default body and space axes agree. Motion: `angular_velocity` in rad/s or
    `angular_momentum` in kg m^2/s, both in the axes `frame`, "body" (the default) or "space"; or `euler_rates` in rad/s, of the
    Euler angles. `normalize` takes attitudes that were rounded to a few digits. The other arguments are fields of the scene;
    lists may have one row for each of the `members` of an ensemble. `step`: seconds; by default a hundredth of a turn, rounded
    to one digit.

        scene = stiefel.body_scene(inertia_tensor=I, attitude=[0, 0, 0.7071, 0.7071], order="xyzw", normalize=True,
                                   angular_velocity=np.radians([0.1, 2, 0.1]), frame="space", epoch="2026-03-01T00:00:00Z")
    """
    given = dict(moments=moments, inertia_tensor=inertia_tensor, attitude=attitude, mrp=mrp, euler_angles=euler_angles,
                 order=None if attitude is None and order == ORDERS[0] else order, sequence=sequence, angular_velocity=angular_velocity, angular_momentum=angular_momentum, frame=frame,
                 euler_rates=euler_rates)
    for group in (_GROUPS[0], _GROUPS[2]):
        if sum(given[name] is not None for name in group) != 1:
            raise refused(group[0], f"exactly one of {', '.join(group[:-1])} and {group[-1]} must be given")
    walk = Walk(members)
    walk.read(given, pb.Body(), "")
    fields = {"attitude": np.array([1.0, 0, 0, 0]), **fields_of(walk.beside, "", normalize)}
    lists: Any = {name: value.tolist() for name, value in fields.items()}
    scene: Scene = {"system": system, "step": _step(fields["angular_velocity"]) if step is None else step, "body": lists}
    more: Any = dict(epoch=None if epoch is None else epoch_text(epoch), horizon=horizon, method=method, tolerance=tolerance, members=members)
    scene.update({name: value for name, value in more.items() if value is not None})  # type: ignore[typeddict-item]
    return scene


def put_fields(body: pb.Body, given: Mapping[str, Any], path: str, normalize: bool, before: Mapping[str, NDArray[Any]] = {}) -> None:
    """Sets the fields of a message, as `fields_of` returns them."""
    for name, value in fields_of(given, path, normalize, before).items():
        getattr(body, name).extend(value.ravel().tolist())


def fields_of(given: Mapping[str, Any], path: str, normalize: bool, before: Mapping[str, NDArray[Any]] = {}) -> dict[str, NDArray[Any]]:
    """Returns the fields of the message Body, (numbers) or (members, numbers), of what a walk has read for it, with those of
    `before` that nothing takes the place of. `path`: what stands before the names in errors."""
    def absent(name: str, where: str) -> InvalidArgument:
        return refused(path + name, f"{shown(np.asarray(given[name]).tolist())}: must be absent where {where} given")

    for name, choices, lists in _MEANINGS:
        if choices and given.get(name) not in (None, *choices):
            raise refused(path + name, f"{given[name]!r}: must be one of {', '.join(choices)}")
        if name in given and not {*lists} & {*given}:
            raise absent(name, f"{' or '.join(lists)} is not")
    for group in _GROUPS:
        one, *more = [name for name in given if name in group] or [""]
        if more:
            raise absent(more[0], f"{one} is")
    fields = {name: value for name, value in before.items() if not any(name in group and {*group} & {*given} for group in _GROUPS)}
    fields.update({name: value for name, value in given.items() if name in _FIELDS})
    if "inertia_tensor" in given and given["inertia_tensor"].shape[-2:] == (3, 3):
        fields["inertia_tensor"] = of_symmetric(path + "inertia_tensor", given["inertia_tensor"])
    # A quaternion that stays as it is, the server checks.
    if "attitude" in given and (normalize or given["attitude"].shape[-2:] == (3, 3) or not {*given} <= {*_FIELDS}):
        fields["attitude"] = of_any(path + "attitude", given["attitude"], given.get("order") == "xyzw", normalize)
    if "mrp" in given:
        fields["attitude"] = of_mrp(given["mrp"])
    if "euler_angles" in given:
        fields["attitude"], omega = of_euler(path + "sequence", given.get("sequence"), given["euler_angles"], given.get("euler_rates"))
    vector = omega if "euler_rates" in given else given.get("angular_momentum", given.get("angular_velocity"))
    if vector is not None and given.get("frame") == "space" and "attitude" in fields:
        vector = _rotations.rotated(_rotations.inverse(fields["attitude"]), vector)
    if "angular_momentum" in given:
        if "moments" not in fields and "inertia_tensor" not in fields:
            raise refused(path + "moments", "exactly one of moments and inertia_tensor must be given")
        tensor = fields["moments"][..., np.newaxis] * np.eye(3) if "moments" in fields else fields["inertia_tensor"][..., _PLACES]
        vector = np.linalg.solve(tensor, vector[..., np.newaxis])[..., 0]
    return fields if vector is None else {**fields, "angular_velocity": vector}


def _step(velocities: NDArray[Any]) -> float:
    """Returns about a hundredth of a turn at the largest angular velocity, with one digit; 1 s at rest."""
    fastest = float(np.max(np.linalg.norm(velocities, axis=-1)))
    return float(f"{2 * np.pi / fastest / 100:.0e}") if 0 < fastest < np.inf else 1.0
