"""Pictures of results: each draws its data and has a legend, and what cannot be drawn is refused."""
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import pytest

import stiefel
from stiefel._report import page, run_data
from stiefel._results import body, diagram, sphere

SPACECRAFT = {"system": "rigid_body", "step": 1, "body": {"moments": [1200, 900, 500], "angular_velocity": [0.002, 0.06, 0.001]}}
TENSOR = {"system": "rigid_body", "step": 0.5, "body": {"inertia_tensor": [17023.3, 124825.7, 129112.2, 397.1, -2171.4, 344.2],
                                                        "angular_velocity": [0.0048, 0.0019, 0.0273]}}
FRAMES = {"stiefel": ["row 0", "row 1"], "ellipsoid": ["q"], "rigid_body_8": [f"column {k}" for k in range(6)]}


@pytest.fixture(autouse=True)
def closed():
    yield
    plt.close("all")


@pytest.fixture(scope="module")
def run(client):
    with client.create(SPACECRAFT) as session:
        return session.trajectory(to=700, fields=["quaternion", "angular_velocity", "angular_velocity_space"])


def curves(axes):
    return {line.get_label(): line.get_ydata() for line in axes.lines}


def legend(axes):
    return [text.get_text() for text in axes.get_legend().get_texts()]


def test_a_run(run, client):
    attitude, rates, spin_axis, accuracy, polhode = run.plot(run.panels).axes[:2] + run.plot(["spin_axis", "accuracy", "polhode"]).axes
    assert run.panels == ("attitude", "rates", "spin_axis", "polhode", "accuracy")
    assert [np.array_equal(curves(attitude)[name], run["quaternion"][:, k]) for k, name in enumerate("wxyz")] == [True] * 4
    assert [np.array_equal(curves(rates)[rf"$\omega_{name}$"], run["angular_velocity"][:, k]) for k, name in enumerate("xyz")] == [True] * 3
    velocity = run["angular_velocity_space"]
    np.testing.assert_allclose(np.transpose([curves(spin_axis)[name] for name in "XYZ"]), velocity / np.linalg.norm(velocity, axis=1, keepdims=True), atol=1e-12)
    with client.create(SPACECRAFT) as session:
        last = session.diagnose(to=700, invariants="energy").invariants[0]
    assert curves(accuracy)["drift of energy"][-1] == max(last.drift, 2.0**-53) and accuracy.get_yscale() == "log"
    assert {"drift of energy", "drift of orthogonality", "error of the attitude"} <= set(legend(accuracy))
    assert legend(attitude) == list("wxyz") and legend(polhode) == ["separatrix", "polhode", "start"]
    for axes in (attitude, rates, accuracy):  # no two curves of a panel share dashes and marks
        looks = [(line.get_linestyle(), line.get_marker(), tuple(line._dash_pattern[1] or ())) for line in axes.lines]
        assert len(set(looks)) == len(looks)
    assert max(run.plot(["accuracy"], to=20).axes[0].lines[0].get_xdata()) == 20


def test_days_where_seconds_are_too_many_and_a_member():
    scene = {**SPACECRAFT, "step": 3600, "members": 2, "body": {"moments": [3, 2, 1], "angular_velocity": [[2e-5, 2e-4, 1e-5], [1e-5, 2e-4, 0]]}}
    run = stiefel.simulate(scene, to=240, every=1)
    axes, = run.plot(["rates"], member=1).axes
    assert np.array_equal(curves(axes)[r"$\omega_x$"], run["angular_velocity"][:, 1, 0])
    axes.figure.canvas.draw()
    labels = {label.get_text(): tick for tick, label in zip(axes.get_xticks(), axes.get_xticklabels())}
    assert axes.get_xlabel() == "time (days)" and labels["4"] == 4 * 86400


def test_a_polhode_is_on_its_sphere(run, client):
    """Its points are those of the samples, turned towards the viewer; each visible one is drawn at full strength."""
    axes, = run.polhode().axes
    momenta = run["angular_velocity"] * [1200, 900, 500]
    u = (momenta / np.linalg.norm(momenta, axis=1, keepdims=True))[:, [2, 1, 0]]  # moments in ascending order
    x, y, depth = sphere._view(0.6, 0.9) @ u.T
    front, seen = next(line for line in axes.lines if line.get_label() == "polhode"), depth >= 0
    assert 0.2 < seen.mean() < 1 and np.allclose(front.get_xdata()[seen], x[seen]) and np.allclose(front.get_ydata()[seen], y[seen])
    assert {text.get_text() for text in axes.texts} == {f"{sign}{name}" for sign in "+−" for name in "xyz"}
    moments = np.array([1.0, 2.0, 5.0])
    for curve in [*sphere.separatrix(moments), *sphere.other_polhodes(moments)]:
        assert np.allclose(np.sum(curve**2, axis=1), 1) and np.ptp(np.sum(curve**2 / moments, axis=1)) < 1e-12
    assert "separatrix" not in legend(stiefel.simulate({**SPACECRAFT, "body": {"moments": [1, 1, 2], "angular_velocity": [1, 2, 3]}}, to=3).polhode().axes[0])
    told = stiefel.simulate(TENSOR, to=9).polhode().axes[0].get_legend().get_title().get_text()
    assert "\na = (1, -0.00374, 0.0194) in body axes x, y, z\n" in told


@pytest.mark.parametrize("system, right", [("rigid_body", False), ("right_rigid_body", True)])
def test_attitudes_momenta_and_principal_axes(client, system, right):
    """I omega in principal axes and R I omega, which is constant, from Q and M alone; `plot3d` draws the axes of the body."""
    M = np.array([[0, -3, 2], [3, 0, -1], [-2, 1, 0.0]])
    scene = {"system": system, "inertia": [1, 2, 3], "step": 0.1, "initial": {"Q": np.eye(3), "M": -M if right else M}}
    for given, fields in ((scene, ["Q", "M"]), (TENSOR, ["Q", "M"]), (TENSOR, ["quaternion", "angular_velocity"])):
        with client.create(given) as session:
            run = session.trajectory(to=40, fields=fields)
        inertia, momenta, R = body.principal(run.scene, None), body.momenta(run.scene, run, None), body.attitudes(run, None)
        in_space = np.einsum("sij,sj->si", R, momenta)
        assert np.ptp(in_space, axis=0).max() < 1e-12 * abs(momenta).max() and np.linalg.det(R).min() > 0.99
        assert np.allclose(inertia.axes @ inertia.axes.T, np.eye(3)) and np.allclose(inertia.momentum(inertia.velocity(momenta)), momenta)
        axes, = run.plot3d().axes
        assert legend(axes) == ["body x", "body y", "body z"] and axes.get_xlabel() == "space X"
        assert np.allclose(np.transpose(axes.lines[0].get_data_3d()), R[:, :, 0], rtol=0, atol=1e-15)


@pytest.mark.parametrize("name", FRAMES)
def test_frames_in_three_coordinates(client, name):
    with client.create(name) as session:
        run = session.trajectory(to=30)
    axes, = run.plot3d(coordinates=(2, 0, 1)).axes
    first = {"ellipsoid": lambda: run["q"], "stiefel": lambda: run["Q"][:, 0], "rigid_body_8": lambda: run["Q"][:, :, 0]}[name]()
    assert legend(axes) == FRAMES[name] and np.array_equal(np.transpose(axes.lines[0].get_data_3d()), first[:, [2, 0, 1]])
    with pytest.raises(ValueError, match="coordinates: .*must be three of 0 to"):
        run.plot3d(coordinates=(0, 1, 90))


def test_what_cannot_be_drawn_is_refused(client):
    with client.create("double_bracket") as session:
        run = session.trajectory(to=3)
    with client.create(SPACECRAFT) as session:
        rates = session.trajectory(to=5, fields=["angular_velocity"])
    rest = stiefel.simulate({**SPACECRAFT, "body": {"moments": [1, 2, 3], "angular_velocity": [0, 0, 0]}}, to=1)
    for picture, said in ((run.plot3d, "complex"), (run.polhode, "no momentum"), (rest.polhode, "at rest"),
                          (lambda: rates.plot(["attitude"]), "panels: .*must be among rates, polhode, accuracy"), (lambda: rates.plot([]), "panels")):
        with pytest.raises(ValueError, match=said):
            picture()
    assert set(name[:5] for name in curves(run.plot(["rates"]).axes[0])) == {"Re P[", "Im P["}


def test_a_notebook_shows_a_figure_once(run, monkeypatch):
    """It shows what pyplot holds, and the value of a cell besides."""
    own = plt.figure()
    assert run.plot(["rates"], figure=own) is own and run.polhode(own.add_subplot()) is own and plt.get_fignums() == [own.number]
    monkeypatch.setattr(plt, "get_backend", lambda: "module://matplotlib_inline.backend_inline")
    for figure in (run.plot(["rates"]), run.polhode(), run.plot3d()):
        assert figure.axes and plt.get_fignums() == [own.number]


def test_error_against_cost(client):
    tradeoff = client.tradeoff({**SPACECRAFT, "step": 0.2, "body": {"moments": [1, 2, 3], "angular_velocity": [0.1, 1, 0.1]}}, horizon=4.0, budget=3e8, repeats=2)
    known, reached = tradeoff.reference_error, [point for point in tradeoff.points if point.success]
    assert all(point.error == max(point.attitude_error, point.momentum_error) for point in reached)
    for cost, error in (("work", "error"), ("time", "drift")):
        axes = tradeoff.plot(cost=cost, error=error)
        drawn = {tuple(point) for line in axes.lines for point in np.asarray(line.get_xydata())}
        assert {(point.work if cost == "work" else np.median(point.cpu_seconds_per_second), max(getattr(point, error), known)) for point in reached} <= drawn
        front = curves(axes)["Pareto front: no point beats these in both"]
        assert len(legend(axes)) > 8 and (np.diff(front) < 0).all() and tradeoff.machine in axes.get_title(loc="left")
        assert cost == "time" or list(front) == [max(point.error, known) for point in tradeoff.front]
    with pytest.raises(ValueError, match="cost: 'money'"):
        tradeoff.plot(cost="money")
    frame = pytest.importorskip("pandas") and tradeoff.to_dataframe()
    assert frame.attrs["horizon"] == 4.0 and list(frame["work"]) == [point.work for point in tradeoff.points] and frame["front"].sum() == len(tradeoff.front)
    assert diagram.dominated_area([(10, 1e-6), (1, 1e-3)], (100, 1)) == pytest.approx(np.log(100) * np.log(1e3) + np.log(10) * np.log(1e3))
    assert diagram.pareto_front([(3, 1), (1, 2), (2, 3), (4, 0.5), (4, 0.7)]) == [(1, 2), (3, 1), (4, 0.5)]


def test_sections_and_exponents(client):
    scene = {"system": "ellipsoid", "inertia": [1, 2, 3], "step": 0.05, "members": 2, "method": {"name": "variational"},
             "initial": {"q": [[[1, 0, 0]], [[0, 1, 0]]], "qdot": [[[0, 1, 0.3]], [[1, 0, 0.5]]]}}
    with client.create(scene) as session:
        section = session.poincare({"q": [0, 0, 1]}, to=500, coordinates=[{"q": [1, 0, 0]}, lambda s: s.time])
    axes = section.plot(x=1, y=0, markersize=4)
    for member, line in enumerate(axes.lines):
        np.testing.assert_array_equal(line.get_xydata(), section.points[section.member == member][:, [1, 0]])
    with pytest.raises(ValueError, match="x, y: 0, 2: must be columns of points, of which there are 2"):
        section.plot(x=0, y=2)
    with client.create({**SPACECRAFT, "method": {"name": "variational"}}) as session:
        spectrum = session.lyapunov(to=4000, every=500, count=2)
    axes = spectrum.plot()
    assert legend(axes) == [r"$\lambda_{1}$", r"$\lambda_{2}$"] and axes.get_title(loc="left") == str(spectrum.verdict)
    np.testing.assert_array_equal(curves(axes)[r"$\lambda_{2}$"], spectrum.history[:, 1])
    np.testing.assert_allclose(axes.collections[0].get_segments()[0][:, 1], spectrum.exponents[0] + spectrum.errors[0] * np.array([-1, 1]))


@pytest.mark.parametrize("dearest, points", [(1.0, 2), (1e30, 21)])
def test_an_error_is_a_curve_however_dear(client, monkeypatch, dearest, points):
    monkeypatch.setattr(run_data, "DEAREST", dearest)
    with client.create("stiefel") as session:
        run = run_data.accuracy(session, 100)
        shown = page.data(session, 40, estimate_error=False)
    assert len(run.error_time) == len(run.errors["attitude"]) == points and run.error_time[0] == 0 and run.error_time[-1] == run.horizon
    assert shown["tradeoff"]["horizon"] == shown["horizon"] == 40 * session.scene["step"] and shown["error"]["last"] is None
