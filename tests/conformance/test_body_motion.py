"""The closed form of a body's motion that Diagnose gives, and events of extrema, beside mpmath's elliptic functions."""
import grpc
import numpy as np
import pytest

import scenes
import stiefel
from stiefel import v1 as pb
from stiefel.v1 import simulation_pb2_grpc as rpc

mp = pytest.importorskip("mpmath", reason="python3-mpmath is not installed")
rng = np.random.default_rng(3)
BODIES = [(np.sort(rng.uniform(1, 1.5, 3)), rng.normal(size=3)) for _ in range(6)]
BODIES += [(np.array([1, 1.5, 2.0]), np.array(m)) for m in ([0.1, 2, 0.1], [1e-6, 1, 1e-7], [1, 1e-9, 1e-9], [1e-9, 0, 1], [0.3, 1, 0.3])]
BODIES += [(np.array([1, 1, 1.5]), np.array([1, 0.3, 1])), (np.array([1, 1.5, 1.5]), np.array([1, 0.3, 1]))]


class ByMpmath:
    """Jacobi's closed form of moments I_1 <= I_2 <= I_3 and a momentum, in 40 digits."""

    def __init__(self, I, m):
        with mp.workdps(40):
            I1, I2, I3 = self.I = [mp.mpf(float(x)) for x in I]
            self.m = [mp.mpf(float(x)) for x in m]
            L2, E2 = sum(x * x for x in self.m), sum(x * x / i for x, i in zip(self.m, self.I))
            above, below = E2 * I3 - L2, L2 - E2 * I1
            self.short = L2 > E2 * I2
            if self.short:
                self.k2, self.speed = (I2 - I1) * above / ((I3 - I2) * below), mp.sqrt((I3 - I2) * below / (I1 * I2 * I3))
                n = -I1 * above / (I3 * below)
            else:
                self.k2, self.speed = (I3 - I2) * below / ((I2 - I1) * above), mp.sqrt((I2 - I1) * above / (I1 * I2 * I3))
                n = -I1 * (I3 - I2) / (I3 * (I2 - I1))
            self.K = mp.ellipk(self.k2)
            self.rate = mp.sqrt(L2) / I1 * (1 - (I3 - I1) / I3 * mp.ellippi(n, self.k2) / self.K)
            self.energy = E2 / 2
            # The squares of m along the axis: the largest, where m_2 = 0, and the least, where m_2^2 is largest.
            along = ((I3 * below / (I3 - I1), I3 * (L2 - E2 * I2) / (I3 - I2)) if self.short else
                     (I1 * above / (I3 - I1), I1 * (E2 * I2 - L2) / (I2 - I1)))
            self.nutation = [float(mp.acos(mp.sqrt(x / L2))) for x in along]


@pytest.fixture(scope="module")
def motion_of(address):
    """Returns the message `motion` of Diagnose for a scene; None where it is absent."""
    with stiefel.Client(address) as client, grpc.insecure_channel(address) as channel:
        stub = rpc.SimulationServiceStub(channel)

        def motion(scene):
            with client.create(scene) as session:
                reply = stub.Diagnose(pb.DiagnoseRequest(session_id=session.id, to=1))
            return reply.motion if reply.HasField("motion") else None
        yield motion


def free_body(I, m, **changes):
    return {**scenes.body(moments=I, angular_velocity=np.asarray(m) / I), "method": {"name": "exact"}, "step": 0.1, **changes}


@pytest.mark.parametrize("I, m", BODIES)
def test_periods_are_those_of_the_integrals(motion_of, I, m):
    found, exact = motion_of(free_body(I, m)), ByMpmath(I, m)
    separatrix = float(1 - exact.k2)
    # Near the separatrix m decides 1 - k^2 only to its rounding, u / (1 - k^2), of which the period has the logarithm.
    bound = max(1e-12, 1e-15 / separatrix)
    assert found.kind == (pb.MOTION_KIND_SHORT_AXIS if exact.short else pb.MOTION_KIND_LONG_AXIS)
    assert found.period == pytest.approx(float(4 * exact.K / exact.speed), rel=bound)
    assert found.precession_period == pytest.approx(float(2 * mp.pi / exact.rate), rel=bound)
    assert found.separatrix == pytest.approx(separatrix, rel=bound)
    assert found.energy == pytest.approx(float(exact.energy), rel=1e-15)
    assert [found.least_nutation, found.largest_nutation] == pytest.approx(exact.nutation, rel=max(bound, 1e-9), abs=1e-14)
    np.testing.assert_allclose(found.moments, I, rtol=1e-15)


def test_axes_and_momentum_are_those_of_the_caller(motion_of):
    """A body whose axes are turned by R, in a turned attitude."""
    random = np.random.default_rng(1)
    R, Q = (np.linalg.qr(random.normal(size=(3, 3)))[0] for _ in range(2))
    R, Q = R * np.linalg.det(R), Q * np.linalg.det(Q)
    tensor, omega = R @ np.diag([3.0, 1, 2]) @ R.T, np.array([0.2, 1, -0.4])
    q = np.array([1 + np.trace(Q), Q[2, 1] - Q[1, 2], Q[0, 2] - Q[2, 0], Q[1, 0] - Q[0, 1]])
    found = motion_of({**scenes.body(), "body": {"inertia_tensor": tensor[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]],
                                                 "attitude": q / np.linalg.norm(q), "angular_velocity": omega}})
    axes = np.reshape(found.axes, (3, 3))
    assert np.linalg.det(axes) == pytest.approx(1)
    np.testing.assert_allclose(axes @ np.diag(found.moments) @ axes.T, tensor, rtol=0, atol=1e-13)
    np.testing.assert_allclose(found.momentum, Q @ tensor @ omega, rtol=0, atol=1e-13)


def test_every_form_of_a_body_has_the_motion_and_nothing_else(motion_of):
    body = scenes.free(3)
    expected = motion_of(body)
    for system in ("symmetric_rigid_body", "reduced_rigid_body", "mclachlan_scovel", "stiefel_momentum"):
        found = motion_of({**body, "system": system, "method": {"name": "rk4"}})
        assert found.period == pytest.approx(expected.period, rel=1e-12)
        assert found.momentum == pytest.approx(expected.momentum, rel=1e-12)
    right = {**body, "system": "right_rigid_body", "method": {"name": "rk4"},
             "initial": {"Q": body["initial"]["Q"].T, "M": -body["initial"]["M"]}}
    assert motion_of(right).precession_period == pytest.approx(expected.precession_period, rel=1e-12)
    assert motion_of(right).momentum == pytest.approx(expected.momentum, rel=1e-12)
    assert motion_of({**body, "initial": {"M": body["initial"]["M"]}}).period == expected.period
    for other in (scenes.free(4), scenes.frame(1, 3), scenes.moser_veselov(), scenes.BIT_SCENES["ensemble"]):
        assert motion_of(other) is None


@pytest.mark.parametrize("m, kind", [([0, 0, 0], "AT_REST"), ([0, 0, 2], "STEADY"), ([0, 2, 0], "STEADY"), ([1, 0, 0], "STEADY"),
                                     ([1, 0, 2**0.5], "SEPARATRIX")])
def test_what_has_no_period(motion_of, m, kind):
    """Of the moments 1, 2 and 4, m_3^2 = 2 m_1^2 is the separatrix."""
    found = motion_of(free_body(np.array([1, 2, 4.0]), m, body={"moments": [1, 2, 4], "angular_velocity": np.array(m) / [1, 2, 4]}))
    kinds = ("SEPARATRIX", "SHORT_AXIS", "LONG_AXIS") if kind == "SEPARATRIX" else (kind,)  # the root of 2 is rounded
    assert pb.MotionKind.Name(found.kind)[len("MOTION_KIND_"):] in kinds
    if kind == "SEPARATRIX":
        assert found.separatrix < 1e-15
        return
    assert not found.HasField("period") and found.HasField("precession_period") == (kind != "AT_REST")
    if kind == "STEADY":
        assert found.precession_period == pytest.approx(2 * np.pi / np.linalg.norm(np.array(m) / [1, 2, 4]))


METHODS = [({"name": "exact"}, 0.1, 2e-12), ({"name": "exact"}, 0.7, 2e-12), ({"name": "preprocessed_variational", "order": 10}, 0.1, 2e-11),
           ({"name": "variational", "order": 8}, 0.1, 1e-9), ({"name": "adaptive", "tolerance": 1e-13}, 0.1, 1e-9)]


@pytest.mark.parametrize("method, step, bound", METHODS)
def test_extrema_of_the_angular_velocity_are_where_jacobis_functions_have_them(client, method, step, bound):
    """About the axis 3, omega_1 ~ cn, omega_2 ~ sn and omega_3 ~ dn; the time is 0 where sn is."""
    I, m = np.array([1, 1.5, 2.0]), np.array([0.5, 0, 1])
    exact = ByMpmath(I, m)
    assert exact.short
    quarter, steps = float(exact.K / exact.speed), 400
    with client.create(free_body(I, m, method=method, step=step)) as session:
        asked = [{"field": "angular_velocity", "coefficients": row, "extremum": True, "level": 7} for row in np.eye(3)]
        found = session.events(steps, [*asked, {**asked[2], "direction": "falling", "limit": 3}], fields="angular_velocity")
    end = steps * step
    times = {0: np.arange(2, end / quarter, 2), 1: np.arange(1, end / quarter, 2), 2: np.arange(1, end / quarter), 3: [2, 4, 6]}
    for event, expected in times.items():
        here = found.event == event
        assert here.sum() == len(expected), event
        assert abs(found.time[here] - np.asarray(expected) * quarter).max() < bound, (event, method)
    highest = found["angular_velocity"][found.event == 3][:, 2]
    assert highest == pytest.approx(m[2] / I[2], rel=1e-9)  # dn = 1 at its maxima


def test_extrema_of_frames_in_ensembles_and_their_refusal(client):
    """Great circles q = (cos t, sin t, 0), at speeds 1 and 2, on V(1, 3): the first number is extreme at multiples of pi."""
    great = {"system": "stiefel", "inertia": [1, 1, 1], "step": 0.05, "members": 2, "method": {"name": "variational", "order": 8},
             "initial": {"Q": [[1, 0, 0], [1, 0, 0]], "S": [[0, 1, 0], [0, 2, 0]]}}
    event = {"field": "Q", "coefficients": [1, 0, 0], "extremum": True}
    with client.create(great) as session:
        found = session.events(400, [event, {**event, "direction": "rising", "limit": 2, "terminal": True}])
    for member, speed in ((0, 1), (1, 2)):
        minima = np.pi * np.array([1, 3]) / speed
        assert found.time[(found.event == 1) & (found.member == member)] == pytest.approx(minima, abs=1e-10)
        both = found.time[(found.event == 0) & (found.member == member)]
        assert both == pytest.approx(np.pi * np.arange(1, 4) / speed, abs=1e-10)
    with client.create(scenes.moser_veselov()) as session:
        with pytest.raises(stiefel.InvalidArgument, match=r"extremum.*must be false: moser_veselov is a discrete system"):
            session.events(10, {**event, "field": "angular_velocity"})
