"""Scenes of a body in three dimensions from what people have: tensors or solids, attitudes in any form, angular velocity or
momentum in body or space axes, or the periods that an observer of light curves knows."""
from __future__ import annotations

from typing import Any, Mapping, Optional, Union

import numpy as np
from numpy.typing import NDArray

from stiefel._given.attitudes import ORDERS, matrices, of_mrp, quaternions
from stiefel._given.instants import epoch_text
from stiefel._given.mappings import BESIDE
from stiefel._given.numbers import SECONDS, number, numbers, refused
from stiefel._given.shapes import of_solids, of_symmetric
from stiefel._given.typed import Method, MethodName, Scene

FRAMES = ("body", "space")
FORMS = BESIDE["Body"]  #: of `body` in a scene, that no message has
_PLACES = ((0, 3, 4), (3, 1, 5), (4, 5, 2))  #: of the matrix entries in Ixx, Iyy, Izz, Ixy, Ixz, Iyz


def body(*, moments: Any = None, inertia_tensor: Any = None, attitude: Any = None, order: str = "wxyz", mrp: Any = None,
         angular_velocity: Any = None, angular_momentum: Any = None, frame: str = "body", normalize: bool = False,
         step: Any = None, epoch: Any = None, horizon: Any = None, method: Union[Method, MethodName, None] = None, tolerance: Any = None,
         members: Optional[int] = None) -> Scene:
    """Returns the scene of a rigid body in three dimensions, in SI units and with the attitude from body to space axes.

    Inertia: `moments` about the body's axes, or `inertia_tensor`, a symmetric 3 x 3 matrix, the six numbers Ixx, Iyy, Izz,
    Ixy, Ixz, Iyz of that matrix, a `Solid` or a list of solids, in an ensemble also a list of these lists. Attitude: `attitude`, a quaternion in the `order` "wxyz" or
    "xyzw" (scipy, SPICE kernels of many tools and ROS write the scalar last), a rotation matrix whose columns are the body
    axes in space, or a Rotation of scipy; or `mrp`, modified Rodrigues parameters; by default body and space axes agree.
    Motion: `angular_velocity` in rad/s or `angular_momentum` in kg m^2/s, both in the axes `frame`, "body" or "space".
    `normalize` takes attitudes that were rounded to a few digits. The other arguments are fields of the scene; lists may
    have one row for each of the `members` of an ensemble. `step`: seconds; by default a hundredth of a turn, rounded to one
    digit.

        scene = stiefel.body(inertia_tensor=I, attitude=[0, 0, 0.7071, 0.7071], order="xyzw", normalize=True,
                             angular_velocity=np.radians([0.1, 2, 0.1]), frame="space", epoch="2026-03-01T00:00:00Z")
    """
    if (angular_velocity is None) == (angular_momentum is None):
        raise refused("angular_velocity", "exactly one of angular_velocity and angular_momentum must be given")
    given = dict(attitude=attitude, order=order, mrp=mrp, angular_velocity=angular_velocity,
                 angular_momentum=angular_momentum, frame=frame)
    inertia, _ = _inertia("", moments, inertia_tensor, members)
    fields = with_fields({**inertia, **{name: value for name, value in given.items() if value is not None}}, "", normalize)
    lists: Any = {name: np.asarray(value).tolist() for name, value in {"attitude": [1.0, 0.0, 0.0, 0.0], **fields}.items()}
    scene: Scene = {"system": "rigid_body", "step": _step(fields["angular_velocity"]) if step is None else step, "body": lists}
    if epoch is not None:
        scene["epoch"] = epoch_text(epoch)
    return _with(scene, horizon=horizon, method=method, tolerance=tolerance, members=members)


def has_forms(given: Mapping[str, Any]) -> bool:
    """Returns whether the `body` of a scene has what `with_fields` writes in other fields."""
    attitude: Any = given.get("attitude")
    if any(name in given for name in FORMS) or hasattr(attitude, "as_quat"):
        return True
    try:
        return bool(np.shape(attitude)[-2:] == (3, 3))
    except ValueError:  # lists of different length
        return False


def with_fields(given: Mapping[str, Any], path: str, normalize: bool, members: Optional[int] = None) -> dict[str, Any]:
    """Returns the `body` of a scene with the fields that the server knows: `order` and `mrp` become `attitude`, and
    `angular_momentum` and `frame` become `angular_velocity`. `path`: what stands before the names in errors."""
    fields = {name: value for name, value in given.items() if name not in FORMS and value is not None}
    order, mrp, momentum, frame = (given.get(name) for name in FORMS)
    for name, value, choices in (("order", order, ORDERS), ("frame", frame, FRAMES)):
        if value is not None and value not in choices:
            raise refused(path + name, f"{value!r}: must be one of {', '.join(choices)}")
    attitude = fields.get("attitude")
    if mrp is not None and attitude is not None:
        raise refused(path + "mrp", "must be absent where attitude is given")
    if momentum is not None and "angular_velocity" in fields:
        raise refused(path + "angular_momentum", "must be absent where angular_velocity is given")
    q = (of_mrp(path + "mrp", mrp) if mrp is not None else np.array([1.0, 0, 0, 0]) if attitude is None
         else quaternions(path + "attitude", attitude, order or "wxyz", normalize))
    if mrp is not None or attitude is not None:
        fields["attitude"] = q
    name, unit = ("angular_velocity", "rad/s") if momentum is None else ("angular_momentum", "kg*m**2/s")
    moving = fields.get(name) if momentum is None else momentum
    if moving is None:
        return fields
    vector = numbers(path + name, moving, unit)
    if vector.shape[-1:] != (3,) or vector.ndim > 2:
        raise refused(path + name, f"the shape {vector.shape}: must be (3) or (members, 3)")
    if frame == "space":
        vector = np.einsum("...ji,...j->...i", matrices(path + "attitude", q), vector)
    if momentum is not None:
        inertia, tensor = _inertia(path, fields.get("moments"), fields.get("inertia_tensor"), members)
        vector = np.linalg.solve(tensor, vector[..., np.newaxis])[..., 0]
        fields.update(inertia)
    fields["angular_velocity"] = vector
    return fields


def tumbling(P_phi: Any, P_psi: Any, mode: str, *, moments: Any = None, axis_ratios: Any = None, pole: Any = (0.0, 0.0, 1.0),
             phi: float = 0.0, psi: float = 0.0, step: Any = None, epoch: Any = None, horizon: Any = None) -> Scene:
    """Returns the scene of a body in the state that an observer of light curves knows, as Pravec et al. (Icarus 233, 2014,
    48) describe it.

    `P_phi`: the mean period of the precession phi of the axis z about the angular momentum; `P_psi`: the period of the
    rotation psi about z, in seconds or with units. `step` and `epoch` are those of `body`. `mode`: "SAM", where z is the axis of the largest moment and psi turns
    backwards, or "LAM", where z is the axis of the smallest moment. The body: `moments` along x, y, z up to a common factor,
    or `axis_ratios`, the lengths of a homogeneous ellipsoid along x, y, z. At time 0: `pole`, the direction of the angular
    momentum in space, a vector or its longitude and latitude in radians, and the angles `phi` and `psi` in radians, where
    the attitude is Rz(longitude) Ry(pi/2 - latitude) Rz(phi) Rx(theta) Rz(psi) if x, y, z of these angles are the body's
    axes in cyclic order, z the one of the mode. Raises InvalidArgument where no motion of this body has such periods.
    """
    periods = number("P_phi", P_phi, SECONDS), number("P_psi", P_psi, SECONDS)
    for name, period in zip(("P_phi", "P_psi"), periods):
        if not 0 < period < np.inf:
            raise refused(name, f"{period!r}: must be above 0 and finite")
    I = _moments_of(moments, axis_ratios)
    if mode not in ("SAM", "LAM"):
        raise refused("mode", f"{mode!r}: must be SAM or LAM")
    axis = int(np.argmax(I) if mode == "SAM" else np.argmin(I))
    places = [(axis + 1) % 3, (axis + 2) % 3, axis]  # of the angles' axes x, y, z among the body's
    L, D = _momentum_and_energy(*periods, I[places])
    sin2, cos2, w = np.sin(psi) ** 2, np.cos(psi) ** 2, 1 / I[places]
    g = sin2 * w[0] + cos2 * w[1]
    cosine = np.sqrt((D - g) / (w[2] - g))
    sine = np.sqrt((w[2] - D) / (w[2] - g))
    m = L * np.array([sine * np.sin(psi), sine * np.cos(psi), cosine])
    Q = _pole(pole) @ _Rz(phi) @ _Rx(float(np.arctan2(sine, cosine))) @ _Rz(psi)
    omega, columns = np.empty(3), np.empty((3, 3))
    omega[places], columns[:, places] = m * w, Q
    scene = body(moments=I, attitude=columns, angular_velocity=omega, step=step, epoch=epoch, horizon=horizon, normalize=True)
    return scene


def _momentum_and_energy(P_phi: float, P_psi: float, I: NDArray[Any]) -> tuple[float, float]:
    """Returns L and D = 2 E / L^2 of the motion with these periods about the axis z of I.

    With g = sin^2(psi) / I_x + cos^2(psi) / I_y: phi' = L g and |psi'| = L ((g - D) (g - 1/I_z))^(1/2), so that P_phi / P_psi
    depends on D alone. It falls with the distance of D from 1 / I_z, to 0 at the separatrix, where D = 1 / I of the middle
    axis. The integrands are periodic and smooth, so that equal weights converge faster than any power.
    """
    w = 1 / I
    edge = w[np.argsort(I)[1]]

    def turns(D: float, nodes: int = 64) -> tuple[float, float]:
        """The integrals of 1 / |psi'| and phi' / |psi'| over a turn of psi where L = 1."""
        before = (0.0, 0.0)
        while True:
            angles = 2 * np.pi * np.arange(nodes) / nodes
            g = np.sin(angles) ** 2 * w[0] + np.cos(angles) ** 2 * w[1]
            slow = 1 / np.sqrt((g - D) * (g - w[2]))
            found = 2 * np.pi * float(slow.mean()), 2 * np.pi * float((g * slow).mean())
            if abs(found[1] - before[1]) <= 1e-14 * found[1] or nodes >= 1 << 20:
                return found
            before, nodes = found, 2 * nodes

    def ratio(D: float) -> float:
        return 2 * np.pi / turns(D)[1]  # P_phi / P_psi = 2 pi / (the advance of phi in a turn of psi)

    wanted, ends = P_phi / P_psi, (w[2] + 1e-12 * (edge - w[2]), edge - 1e-9 * (edge - w[2]))
    values = ratio(ends[0]), ratio(ends[1])
    if not min(values) <= wanted <= max(values):
        raise refused("P_psi", f"{P_psi!r}: P_phi / P_psi is {wanted:.6g}, and must be between {min(values):.6g} and "
                               f"{max(values):.6g} for this body and mode")
    low, high = ends if values[0] < values[1] else ends[::-1]
    for _ in range(200):
        middle = (low + high) / 2
        if middle in (low, high):
            break
        low, high = (middle, high) if ratio(middle) < wanted else (low, middle)
    return turns(low)[0] / P_psi, low


def _inertia(path: str, moments: Any, inertia_tensor: Any, members: Optional[int]) -> tuple[dict[str, Any], NDArray[Any]]:
    """Returns the fields of the scene, and the matrices (3, 3) or (members, 3, 3)."""
    if (moments is None) == (inertia_tensor is None):
        raise refused(path + "moments", "exactly one of moments and inertia_tensor must be given")
    if moments is not None:
        I = numbers(path + "moments", moments, "kg*m**2")
        if I.shape[-1:] != (3,) or I.ndim > 2:
            raise refused(path + "moments", f"the shape {I.shape}: must be (3) or (members, 3)")
        return {"moments": I}, I[..., np.newaxis] * np.eye(3)
    solid_or_not = of_solids(path + "inertia_tensor", inertia_tensor, members)
    array = numbers(path + "inertia_tensor", solid_or_not, "kg*m**2")
    if array.shape[-2:] == (3, 3) and array.ndim <= 3:
        array = of_symmetric(path + "inertia_tensor", array)
    elif array.shape[-1:] != (6,) or array.ndim > 2:
        raise refused(path + "inertia_tensor", f"the shape {array.shape}: must be (3, 3), (6), (members, 3, 3) or (members, 6)")
    return {"inertia_tensor": array}, array[..., _PLACES]


def _step(velocities: NDArray[Any]) -> float:
    """Returns about a hundredth of a turn at the largest angular velocity, with one digit; 1 s at rest."""
    fastest = float(np.max(np.linalg.norm(velocities, axis=-1)))
    return float(f"{2 * np.pi / fastest / 100:.0e}") if 0 < fastest < np.inf else 1.0


def _moments_of(moments: Any, axis_ratios: Any) -> NDArray[Any]:
    if (moments is None) == (axis_ratios is None):
        raise refused("moments", "exactly one of moments and axis_ratios must be given")
    given = numbers("moments", moments, "kg*m**2") if axis_ratios is None else numbers("axis_ratios", axis_ratios)
    name = "moments" if axis_ratios is None else "axis_ratios"
    if given.shape != (3,) or not (given > 0).all():
        raise refused(name, f"{given.tolist()!r}: must be three numbers above 0")
    return given if axis_ratios is None else (np.sum(given**2) - given**2) / 5


def _pole(given: Any) -> NDArray[Any]:
    """Returns Rz(longitude) Ry(pi/2 - latitude)."""
    pole = numbers("pole", given)
    if pole.shape == (3,) and np.linalg.norm(pole) > 0:
        pole = np.array([np.arctan2(pole[1], pole[0]), np.arctan2(pole[2], np.hypot(pole[0], pole[1]))])
    if pole.shape != (2,):
        raise refused("pole", f"{given!r}: must be a vector, or longitude and latitude in radians")
    tilt = np.pi / 2 - pole[1]
    return np.asarray(_Rz(pole[0]) @ [[np.cos(tilt), 0, np.sin(tilt)], [0, 1, 0], [-np.sin(tilt), 0, np.cos(tilt)]])


def _Rz(angle: float) -> NDArray[Any]:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])


def _Rx(angle: float) -> NDArray[Any]:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[1, 0, 0], [0, c, -s], [0, s, c]])


def _with(scene: Scene, **fields: Any) -> Scene:
    scene.update({name: value for name, value in fields.items() if value is not None})  # type: ignore[typeddict-item]
    return scene
