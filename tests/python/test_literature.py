"""The programs of client/examples/literature: their numbers beside values that come from elsewhere, their pictures, and the
page that shows both."""
import json
import math
import re
import runpy
import subprocess
import sys
from pathlib import Path

import matplotlib
import numpy as np
import pytest

matplotlib.use("Agg")
from matplotlib.image import imread  # noqa: E402

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "client/examples/literature"
PAGE = (ROOT / "docs/literature.md").read_text(encoding="utf-8")
SCRIPTS = sorted(path.stem for path in FOLDER.glob("*.py"))
NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e[+-]\d+)?")


@pytest.fixture(scope="module")
def printed(tmp_path_factory):
    """Runs a program once, in an empty folder, and returns what it prints and the path of its picture."""
    done = {}

    def of(name):
        if name not in done:
            folder = tmp_path_factory.mktemp(name)
            result = subprocess.run([sys.executable, FOLDER / f"{name}.py", "drawn.png"], cwd=folder, capture_output=True,
                                    text=True)
            assert result.returncode == 0 and not result.stderr, result.stderr
            assert [path.name for path in folder.iterdir()] == ["drawn.png"]
            done[name] = result.stdout, folder / "drawn.png"
        return done[name]

    return of


def numbers(text, pattern):
    """Returns the numbers of the groups of `pattern`, each of which may hold several."""
    found = re.search(pattern, text)
    assert found, text
    return [float(one) for group in found.groups() for one in NUMBER.findall(group)]


def rk4(field, state, h, steps):
    """Yields the states after each step."""
    for _ in range(steps):
        a = field(state)
        b = field(state + h / 2 * a)
        c = field(state + h / 2 * b)
        state = state + h / 6 * (a + 2 * b + 2 * c + field(state + h * c))
        yield state


def body_field(inertia):
    """The vector field of Q and M, stacked, in N dimensions."""
    sums = np.add.outer(inertia, inertia)

    def field(state):
        Omega = state[1] / sums
        return np.stack([state[0] @ Omega, state[1] @ Omega - Omega @ state[1]])

    return field


@pytest.mark.parametrize("name", SCRIPTS)
def test_the_picture(name, printed):
    """It is drawn in grey alone, so that it reads in print, and the one in the tree is small and of the same size."""
    shown, drawn = FOLDER / f"{name}.png", printed(name)[1]
    pixels = imread(drawn)[..., :3]
    assert np.ptp(pixels, axis=2).max() < 0.02 and 0.01 < (pixels < 0.9).all(axis=2).mean() < 0.5
    assert shown.stat().st_size < 150_000 and imread(shown).shape == imread(drawn).shape


@pytest.mark.parametrize("name", SCRIPTS)
def test_the_page_has_picture_sentence_and_command(name, printed):
    """The sentence is the printed one; sizes of errors may differ from one machine to another."""
    def of_any_size(text):
        return re.sub(r"\d\.\de-\d+", "SIZE", " ".join(re.sub("^> ", "", text, flags=re.MULTILINE).split()))

    text = printed(name)[0]
    assert text.endswith(".\n") and text.count("\n") == 1
    assert of_any_size(text) in of_any_size(PAGE)
    assert f"](../client/examples/literature/{name}.png)" in PAGE and f"python3 client/examples/literature/{name}.py" in PAGE


def test_the_integrals_of_moser_and_veselov(printed):
    values = numbers(printed("moser_veselov_integrals")[0], r"integrals (.*) change by at most (\S+) of .* by (\S+)\.\n")
    script = runpy.run_path(str(FOLDER / "moser_veselov_integrals.py"))
    M, L, mu = script["M_0"], np.diag(np.square(script["INERTIA"])), np.arange(-2.0, 3.0)
    of_power = [np.polyfit(mu, [np.trace(np.linalg.matrix_power(M + one * L, k)) for one in mu], 4)[::-1] for k in (2, 3, 4)]
    expected = [of_power[0][0], of_power[2][0], of_power[1][1] / 3, of_power[2][2] / 2]
    assert values[:4] == pytest.approx(expected, abs=1e-6)
    assert values[4] < 2e-14
    # The classical method drifts as this one does, which shares nothing with the engine.
    steps = rk4(body_field(script["INERTIA"]), np.stack([np.eye(4), M]), script["STEP"], script["STEPS"])
    *_, last = (state[1] for state in steps)
    drift = max(abs(np.trace(last @ last @ last @ last) / expected[1] - 1), abs(np.trace(last @ last) / expected[0] - 1))
    assert values[5] == pytest.approx(drift, rel=0.05)


def test_the_orders_of_hairer_and_vilmart(printed):
    """The errors at h = 1/40 were computed by another program with 60 digits."""
    values = numbers(printed("hairer_vilmart")[0], r"seen as (.*); .* errors are (.*), and a step of order 10 takes (\S+) times")
    assert values[:5] == pytest.approx([2, 4, 6, 8, 10], abs=0.3)
    assert values[5:9] == pytest.approx([7.8e-3, 7.2e-6, 3.2e-9, 8.6e-13], rel=0.02)
    assert values[9] < 2e-15 and 0.8 < values[10] < 1.25


def test_the_geodesic_of_jacobi(printed):
    """By the theorem of Chasles the tangents of a geodesic touch one confocal quadric, which gives rho."""
    rho, turned, length, advance, apart = numbers(
        printed("jacobi_ellipsoid")[0],
        r"back at u = (\S+), it does so at (\S+); over a length of (\S+) .* grow to (\S+) and .* within (\S+)\.\n")
    script = runpy.run_path(str(FOLDER / "jacobi_ellipsoid.py"))
    squares, q = np.array([1.0, 4.0, 9.0]), script["START"] / np.linalg.norm(script["START"])
    tangent = script["VELOCITY"] - (script["VELOCITY"] @ q) * q
    x, v = q * np.sqrt(squares), tangent * np.sqrt(squares) / np.sqrt(tangent**2 @ squares)

    def discriminant(w):
        weights = 1 / (squares - w)
        return (x * v @ weights) ** 2 - (x**2 @ weights - 1) * (v**2 @ weights)

    low, high = 1.0 + 1e-6, 4.0 - 1e-6
    assert discriminant(low) * discriminant(high) < 0
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if discriminant(middle) * discriminant(low) > 0 else (low, middle)
    assert rho == pytest.approx(low, abs=2e-8) and turned == pytest.approx(low, abs=1e-6) and apart < 1e-6

    # A geodesic in space accelerates along the normal alone. Its turns about the axis x count the integral in u.
    def field(state):
        normal = state[0] / squares
        return np.stack([state[1], -(state[1] ** 2 @ (1 / squares)) / (normal @ normal) * normal])

    xs = np.array([state[0, 0] for state in rk4(field, np.stack([x, v]), 0.05, round(length / 0.05))])
    crossings = (np.diff(np.sign(xs)) != 0).sum()
    angles = (np.arange(64) + 0.5) * np.pi / 64
    w = 1 + (low - 1) * np.sin(angles) ** 2
    half_turn = 2 * np.pi * np.sqrt(w / ((4 - w) * (9 - w))).mean()
    assert crossings > 20 and abs(advance - crossings * half_turn) < half_turn


def test_the_two_rigid_bodies(printed):
    values = numbers(
        printed("symmetric_representation")[0],
        r"at most (\S+) in Q, (\S+) in M, (\S+) in P; both end with Q_11 = (\S+) and (\S+); at .* P differs by (\S+)\.\n")
    script = runpy.run_path(str(FOLDER / "symmetric_representation.py"))
    *_, last = rk4(body_field(script["INERTIA"]), np.stack([np.eye(4), script["M_0"]]), 0.005, 4000)
    assert values[3:5] == pytest.approx([last[0, 0, 0]] * 2, abs=2e-9)
    assert max(values[:3]) < 1e-12 and 1e-12 < values[5] < 1e-7
    # Psi and its inverse, by the power series of exp(asinh(M / 2)) = M / 2 + (I + M^2 / 4)^(1/2).
    M = script["M_0"] / 4
    square = M @ M / 4
    root = sum(math.prod((0.5 - j) / (j + 1) for j in range(k)) * np.linalg.matrix_power(square, k) for k in range(30))
    assert np.allclose(script["psi_inverse"](np.eye(4), M), M / 2 + root, rtol=0, atol=1e-14)


def test_the_distances(printed):
    """Below pi the logarithm is the drawn velocity; beyond pi a circle is longer than its way back."""
    error, count, below, beyond, any_of, one_of, circle = numbers(
        printed("stiefel_distances")[0],
        r"within (\S+) for all (\d+) velocities up to (\S+) pi; at (\S+) pi for (\d+) % of any and (\d+) % of .* within (\S+)\.\n")
    assert error < 1e-12 and count == 160 and below < 1 < beyond and circle < 1e-12
    assert one_of == 0 and any_of >= 80


def test_the_flips_of_the_handle(printed):
    first, last, off, added, predicted = numbers(
        printed("t_handle")[0], r"spins, (\S+) s to (\S+) s .* within (\S+) of it; .* adds (\S+) s, 2 ln 10 / s is (\S+) s")
    # A bar of 0.3 kg, radius 1 cm and length 12 cm, and a stem of 0.1 kg, 8 mm and 7 cm, whose centre is 3.5 cm beside it.
    m, r, h = np.array([0.3, 0.1]), np.array([0.01, 0.008]), np.array([0.12, 0.07])
    along, across = m * r**2 / 2, m * (3 * r**2 + h**2) / 12
    apart = 0.3 * 0.1 / 0.4 * 0.035**2
    I = np.array([along[0] + across[1] + apart, across[0] + along[1], across[0] + across[1] + apart])
    spin = 5.0

    times, before, h = [], np.array([0.1 * spin, spin, 0]), 1e-3
    for k, omega in enumerate(rk4(lambda w: np.cross(I * w, w) / I, before, h, 6000)):
        if omega[1] * before[1] < 0:
            times.append((k + before[1] / (before[1] - omega[1])) * h)
        before = omega
    assert np.diff(times) == pytest.approx(first, abs=1e-5) and len(times) >= 2

    growth = spin * math.sqrt((I[1] - I[0]) * (I[2] - I[1]) / (I[0] * I[2]))
    complement = 1e-10 * math.sqrt(I[0] * (I[2] - I[0]) / (I[1] * (I[2] - I[1])))
    assert last == pytest.approx(2 / growth * math.log(4 / complement), abs=2e-6)  # K = ln(4 / k') for small k'
    assert added == pytest.approx(predicted, abs=2e-6) and predicted == pytest.approx(2 * math.log(10) / growth, abs=2e-6)
    assert off < 1e-12


def test_the_periods_of_apophis(printed):
    phi, psi, energy, long_axis = numbers(
        printed("apophis")[0], r"P_phi = (\S+) h and P_psi = (\S+) h .* E/E_0 = (\d\.\d+), .* and (\S+) h for")
    assert (phi, psi) == (27.38, 263.0)
    assert long_axis == pytest.approx(1 / (1 / 27.38 - 1 / 263), abs=0.006) and long_axis == pytest.approx(30.56, abs=0.011)
    assert energy == pytest.approx(1.024, abs=0.013)
    # With g = sin^2 psi / I_1 + cos^2 psi / I_2 and 1 / I_3 = 1: phi' = L g, psi' = -L ((g - 1) (g - E/E_0))^(1/2).
    angle = (np.arange(512) + 0.5) * np.pi / 512
    g = np.sin(angle) ** 2 / 0.61 + np.cos(angle) ** 2 / 0.965

    def ratio(energy):
        slow = 1 / np.sqrt((g - 1) * (g - energy))
        return 1 / (g * slow).mean()

    assert ratio(energy - 6e-5) > 27.38 / 263 > ratio(energy + 6e-5)


def test_the_sentence_about_toutatis(client):
    sys.path.insert(0, str(FOLDER.parent))
    import toutatis

    data = json.loads(toutatis.DATA.read_text(encoding="utf-8"))
    with client.create(toutatis.scene(data)) as session:
        angles = np.array([one.angles() for one in toutatis.compare(session, data)])
        error = toutatis.error_in_degrees(session.diagnose(to=toutatis.DAYS * toutatis.DAY, estimate_error=True))
    median, count, most, bound = numbers(
        PAGE, r"are (\S+) degrees from those of the (\d+) observed .* median, and (\S+)\s+> degrees at most; .* below (\S+) degrees")
    assert (len(angles), round(np.median(angles), 2), round(angles.max(), 2)) == (count, median, most) and error < bound
