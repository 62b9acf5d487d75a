"""Evaluates every formula that Describe prints at random states of every system and compares with the server's reports.

The tables of formulas.py have one entry for each exact text. A printed text without an entry fails, and so does an
entry whose text is not printed, so that a text cannot change without its formula being evaluated again.
"""
import numpy as np
import pytest

import formulas
import scenes
import stiefel
from stiefel import v1 as pb

RK4 = {"name": "rk4"}


def skew(random, n, scale=1.0):
    A = random.standard_normal((n, n))
    return scale * (A - A.T)


def rotation(random, n):
    Q = np.linalg.qr(random.standard_normal((n, n)))[0]
    Q[0] *= np.linalg.det(Q)
    return Q


def cayley(A):
    return np.linalg.solve(np.eye(len(A)) - A / 2, np.eye(len(A)) + A / 2)


def body(system, seed, N=4, **changes):
    """Returns a scene with Q, M and ‖Omega‖ of about 1, for every system that takes these blocks."""
    random = np.random.default_rng(seed)
    lam = random.uniform(0.5, 2, N)
    Omega = skew(random, N)
    Omega /= np.linalg.norm(Omega, 2)
    scene = {"system": system, "inertia": lam, "step": 1e-3,
             "initial": {"Q": rotation(random, N), "M": lam[:, None] * Omega + Omega * lam}}
    return {**scene, **changes}


def in_GL(system, seed, h, epsilon=None):
    """Returns a parametric scene with G - G^-1 = epsilon (M + mu/h Lambda^2) for G = Q^-1 P. h = 1 for the flow;
    `epsilon` is h if it is not given."""
    random = np.random.default_rng(seed)
    lam, mu, M = random.uniform(0.5, 2, 4), 0.05, skew(random, 4, 0.3)
    W = (epsilon or h) * (M + mu / h * np.diag(lam**2)) / 2
    root = np.eye(4)
    for _ in range(60):
        root = (root + np.linalg.solve(root, np.eye(4) + W @ W)) / 2
    Q = np.eye(4) + 0.3 * random.standard_normal((4, 4))
    made = {"system": system, "inertia": lam, "parameter": mu, "step": h if h < 1 else 1e-3,
            "initial": {"Q": Q, "P": Q @ (W + root)}}
    return {**made, "epsilon": epsilon} if epsilon else made


def frames(system, seed, n=2, N=5):
    random = np.random.default_rng(seed)
    lam, Q, U = random.uniform(0.5, 2, N), rotation(random, N)[:n], skew(random, N, 0.5)
    S = (Q @ U) * lam
    C = random.standard_normal((n, n))
    initial = {
        "stiefel": {"Q": Q, "S": S},
        "stiefel_costate": {"Q": Q, "P": S + (C + C.T) @ Q},
        "stiefel_momentum": {"Q": Q, "M": Q.T @ S - S.T @ Q},
        "discrete_stiefel": {"Q_prev": Q, "Q": Q @ cayley(0.1 * U)},
    }[system]
    return {"system": system, "inertia": lam, "initial": initial, "step": 1e-3}


def ellipsoid(seed, costate):
    random = np.random.default_rng(seed)
    lam, q, v = random.uniform(0.5, 2, 4), random.standard_normal(4), random.standard_normal(4)
    q /= np.linalg.norm(q)
    second = {"p": v[None]} if costate else {"qdot": (v - (v @ q) * q)[None]}
    return {"system": "ellipsoid", "inertia": lam, "initial": {"q": q[None], **second}, "step": 1e-3}


def double_bracket(seed):
    random = np.random.default_rng(seed)
    block = lambda: (random.standard_normal((2, 3)) + 1j * random.standard_normal((2, 3))) / 2
    return {"system": "double_bracket", "inertia_u": random.uniform(0.5, 2, 2), "inertia_v": random.uniform(0.5, 2, 3),
            "initial": {"Q": block(), "P": block()}, "step": 1e-3}


def pair(seed, N):
    scene = body("moser_veselov_pair", seed, N, step=0.1)
    Q, M, lam = scene["initial"]["Q"], scene["initial"]["M"], scene["inertia"]
    scene["initial"] = {"Q_prev": Q, "Q": Q @ cayley(0.1 * formulas.J_inverse(lam, M))}
    return scene


def reflected(scene):
    scene["initial"]["Q"] = -scene["initial"]["Q"]
    return scene


def with_P(scene, epsilon):
    """Returns the scene with a P that is no rotation, so that P^T Q and Q^T P differ in more than their sign."""
    Q, M = scene["initial"]["Q"], scene["initial"]["M"]
    C = np.random.default_rng(7).standard_normal(Q.shape)
    right = scene["system"].startswith("right")
    P = (C + C.T + epsilon * M / 2) @ Q if right else Q @ (C + C.T + epsilon * M / 2)
    return {**scene, "epsilon": epsilon, "initial": {"Q": Q, "P": P}}


def cases():
    for seed in (1, 2):
        yield f"rigid_body 4 {seed}", body("rigid_body", seed)
        yield f"rigid_body 3 {seed}", body("rigid_body", seed, 3)
        yield f"rigid_body reflected {seed}", reflected(body("rigid_body", seed, 3))
        yield f"moser_veselov 4 {seed}", body("moser_veselov", seed, step=0.1)
        yield f"moser_veselov 3 {seed}", body("moser_veselov", seed, 3, step=0.1)
        yield f"moser_veselov 5 {seed}", body("moser_veselov", seed, 5, step=-0.1)
        for N in (3, 4):
            for system in ("right_rigid_body", "mclachlan_scovel", "symmetric_rigid_body", "reduced_rigid_body",
                           "right_symmetric_rigid_body"):
                yield f"{system} {N} {seed}", body(system, seed, N)
            yield f"symmetric_moser_veselov {N} {seed}", body("symmetric_moser_veselov", seed, N, step=0.1)
            yield f"moser_veselov_pair {N} {seed}", pair(seed, N)
        for epsilon in (0.3, -2.0):
            for system in ("symmetric_rigid_body", "reduced_rigid_body", "right_symmetric_rigid_body"):
                yield f"{system} epsilon {epsilon} {seed}", with_P(body(system, seed), epsilon)
        for epsilon in (None, 0.25, -0.5):
            yield f"parametric_rigid_body {epsilon} {seed}", in_GL("parametric_rigid_body", seed, 1, epsilon)
            yield f"parametric_moser_veselov {epsilon} {seed}", in_GL("parametric_moser_veselov", seed, 0.1, epsilon)
        for n, N in ((2, 5), (1, 3), (3, 3)):
            for system in ("stiefel", "stiefel_costate", "stiefel_momentum", "discrete_stiefel"):
                yield f"{system} {n} {N} {seed}", frames(system, seed, n, N)
        yield f"ellipsoid {seed}", ellipsoid(seed, False)
        yield f"ellipsoid costate {seed}", ellipsoid(seed, True)
        yield f"double_bracket {seed}", double_bracket(seed)


class State:
    """The state of `scene` at step `at`: its fields as attributes, and the functions that formulas.py uses."""

    def __init__(self, scene, fields, at):
        self._scene, self._fields, self._at = scene, fields, at
        self.__dict__.update(fields[at])
        self.h = scene["step"]
        self.mu = scene.get("parameter", 0)
        if "inertia" in scene:
            self.lam = np.asarray(scene["inertia"])
            self.Lam = np.diag(self.lam)
        else:
            self.lam_u, self.lam_v = np.asarray(scene["inertia_u"]), np.asarray(scene["inertia_v"])
        if "epsilon" in fields[at]:
            self.epsilon = float(fields[at]["epsilon"])

    @property
    def next(self):
        return State(self._scene, self._fields, self._at + 1)

    @property
    def U(self):
        return self.Q.T @ self.next.Q

    def dot(self, name):
        """Returns the time derivative of a field by differences of order 4, with an error of about 1e-12."""
        f = lambda j: self._fields[self._at + j][name]
        return (8 * (f(1) - f(-1)) - (f(2) - f(-2))) / (12 * self.h)


AT = 5


def asked(name):
    """Returns the field of a name in Describe; of Euler angles one of the sequences."""
    return name.replace("SEQUENCE", "ZXZ")


class Reported:
    """The session of a scene, its state at step AT, and what Describe says of its system."""

    def __init__(self, client, system, scene):
        self.scene = scene if system.discrete else {**scene, "method": RK4}
        with client.create(self.scene) as session:
            names = [asked(field.name) for field in system.fields]
            offered = [name for name in names if self.has(session, name)]
            run = session.trajectory(to=AT + 2, fields=offered)
            self.fields = [{name: np.asarray(run[name])[k] for name in offered} for k in range(AT + 3)]
            self.x = State(self.scene, self.fields, AT)
            diagnosis = session.diagnose(AT)
            self.invariants = {i.name: i for i in diagnosis.invariants}
            self.orthogonality = diagnosis.orthogonality
            self.forms = [(form, *self.evaluated(session, form)) for form in system.forms]

    @staticmethod
    def has(session, name):
        try:
            session.step(0, fields=[name])
            return True
        except stiefel.InvalidArgument:
            return False

    def evaluated(self, session, form):
        u, v = (tangent(self.x, form.blocks, np.random.default_rng(seed)) for seed in (3, 4))
        return u, v, session.diagnose(AT, ["energy"], forms=[(form.name, u, v)]).forms[0]


def tangent(x, blocks, random):
    """Returns a random tangent vector at a state, block by block."""
    N = len(x.lam)
    along = lambda A: A @ skew(random, N)
    if blocks == "Q, M":
        return {"Q": along(x.Q), "M": skew(random, N)}
    if blocks == "QU, QZ":
        return {"QU": along(x.Q), "QZ": along(x.Q)}
    first, second = blocks.split(", ")
    A = along(getattr(x, first))
    if len(x.Q) == N and second != "S" and not hasattr(x, "Qdot"):
        return {first: A, second: along(getattr(x, second))}
    G = random.standard_normal(x.Q.shape)
    if second == "P":  # keeps Q P^T + P Q^T
        R = G @ x.Q.T + A @ x.P.T
        return {"Q": A, "P": G - (R + R.T) @ x.Q / 2}
    R = (G / x.lam) @ x.Q.T + (A / x.lam) @ x.S.T  # keeps Q Lambda^-1 S^T skew
    Y = formulas.lyapunov((x.Q / x.lam) @ x.Q.T, R + R.T)
    return {"Q": A, "S": G - Y @ x.Q}


@pytest.fixture(scope="module")
def systems(client):
    return {system.name: system for system in client.describe().systems}


@pytest.fixture(scope="module")
def reported(client, systems):
    return {name: Reported(client, systems[scene["system"]], scene) for name, scene in cases()}


@pytest.fixture(scope="module", params=[name for name, _ in cases()])
def case(request, reported, systems):
    found = reported[request.param]
    return found, systems[found.scene["system"]]


def off(pairs):
    """Returns the largest difference of the pairs, relative to their size."""
    worst = 0.0
    for a, b in pairs:
        a, b = np.asarray(a), np.asarray(b)
        worst = max(worst, np.abs(a * 1.0 - b * 1.0).max() / max(1.0, np.abs(b * 1.0).max()))
    return worst


def indices(name):
    return tuple(int(k) for k in name.partition("[")[2].rstrip("]").split(",") if k)


def test_invariants_are_their_formulas(case):
    found, system = case
    for family in system.invariants:
        if family.name == "orthogonality":
            defect = np.abs(formulas.ORTHOGONALITY[family.formula](found.x)).max()
            assert found.orthogonality == pytest.approx(defect, abs=4e-15)
            continue
        values = formulas.INVARIANTS[family.formula](found.x)
        of_family = [i for i in found.invariants.values() if i.name.partition("[")[0] == family.name]
        no_pairs = family.name == "spatial_momentum" and hasattr(found.x, "Q") and len(found.x.Q) == 1
        assert of_family or no_pairs, family.name
        for invariant in of_family:
            expected = values[indices(invariant.name)]
            assert abs(invariant.value - expected) <= 1e-11 * abs(invariant.scale), (
                f"{invariant.name} is {invariant.value}, and {family.formula} is {expected}")


def test_blocks_and_fields_are_what_is_said_of_them(case):
    found, system = case
    for said in [*system.blocks, *system.fields]:
        name = asked(said.name)
        if said.description and name in found.fields[AT]:
            pairs = formulas.FIELDS[said.description](found.x, found.fields[AT][name])
            assert off(pairs) < 1e-9, f"{said.name}: {said.description}"


def test_states_move_by_the_equations(case):
    found, system = case
    assert off(formulas.EQUATIONS[system.equations](found.x)) < 1e-8, system.equations


def test_side_momentum_and_velocity_are_what_is_said(case):
    """Q' = Q Omega on the left, Omega Q on the right; the momentum of the velocity, given in its place, is the same state."""
    found, system = case
    x = found.x
    there = lambda *names: all(name in found.fields[AT] for name in names)
    assert bool(system.side) == there("Q", "Omega")
    assert system.momentum in {"", *(block.name for block in system.blocks)}
    assert bool(system.velocity) == bool(system.momentum and not system.discrete)
    if not system.velocity or not there(system.velocity, system.momentum):
        return
    V = getattr(x, system.velocity)
    S = V * x.lam
    if system.side:
        assert off([(x.dot("Q"), V @ x.Q if system.side == pb.SIDE_RIGHT else x.Q @ V)]) < 1e-8
        assert off([(x.M, S + x.lam[:, None] * V)]) < 1e-9
    elif system.momentum == "P":  # any with the M of S
        assert off([(x.Q.T @ x.P - x.P.T @ x.Q, x.Q.T @ S - S.T @ x.Q)]) < 1e-9
    else:
        assert off([(getattr(x, system.momentum), x.Q.T @ S - S.T @ x.Q if system.momentum == "M" else S)]) < 1e-9


def test_forms_are_their_formulas(case):
    found, _ = case
    for form, u, v, value in found.forms:
        expected = formulas.FORMS[form.blocks, form.formula](found.x, u, v)
        assert value == pytest.approx(expected, rel=1e-10, abs=1e-10), form.formula
        assert abs(expected) > 1e-6


def test_every_text_has_one_formula_and_every_formula_its_text(systems, reported):
    printed = {table: set() for table in ("INVARIANTS", "ORTHOGONALITY", "FIELDS", "EQUATIONS", "FORMS")}
    for system in systems.values():
        printed["EQUATIONS"].add(system.equations)
        for i in system.invariants:
            printed["ORTHOGONALITY" if i.name == "orthogonality" else "INVARIANTS"].add(i.formula)
        printed["FIELDS"] |= {said.description for said in [*system.blocks, *system.fields] if said.description}
        printed["FORMS"] |= {(form.blocks, form.formula) for form in system.forms}
    for table, texts in printed.items():
        assert set(getattr(formulas, table)) == texts, table
    # Every system, block and field has a case.
    offered = {(found.scene["system"], name) for found in reported.values() for name in found.fields[AT]}
    assert {(s.name, asked(f.name)) for s in systems.values() for f in [*s.blocks, *s.fields]} == offered


@pytest.mark.parametrize("system", ["rigid_body", "right_rigid_body", "stiefel"])
def test_orthogonality_is_its_formula_where_it_is_lost(client, systems, system):
    """The reported orthogonality is its formula; the step is so long that the defect is far above rounding."""
    scene = frames(system, 3) if system == "stiefel" else body(system, 3)
    with client.create({**scene, "method": RK4, "step": 0.2}) as session:
        Q, defect = session.step(20)["Q"], session.diagnose(20).orthogonality
    said = next(i.formula for i in systems[system].invariants if i.name == "orthogonality")
    x = State({**scene, "step": 0.2}, [{"Q": Q}], 0)
    assert defect > 1e-9 and defect == pytest.approx(np.abs(formulas.ORTHOGONALITY[said](x)).max(), rel=1e-6)


def test_the_right_momentum_belongs_to_the_left_one(client):
    """With Q_r = Q^T and M_r = -M, [RB] Prop. 2.1, the spatial momenta satisfy m_r = -m."""
    left = scenes.free(4)
    right = {**left, "system": "right_rigid_body", "method": RK4,
             "initial": {"Q": left["initial"]["Q"].T, "M": -left["initial"]["M"]}}
    values = []
    for scene in (left, right):
        with client.create(scene) as session:
            values.append(np.array([i.value for i in session.diagnose(0, ["spatial_momentum"]).invariants]))
    assert np.abs(values[0]).max() > 1e-3
    assert values[1] == pytest.approx(-values[0], rel=1e-12, abs=1e-14)
