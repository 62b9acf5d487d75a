"""Pictures of results: each draws its data and has a legend, and what cannot be drawn is refused."""
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import pytest

import stiefel
from stiefel._results import diagram, sphere

SPACECRAFT = {"system": "rigid_body", "step": 1, "body": {"moments": [1200, 900, 500], "angular_velocity": [0.002, 0.06, 0.001]}}
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


def test_a_run(run):
    assert run.panels == ("attitude", "rates", "spin_axis", "polhode", "accuracy")
    attitude, rates, spin_axis, accuracy = run.plot(["attitude", "rates", "spin_axis", "accuracy"]).axes
    assert all(np.array_equal(curves(attitude)[name], run["quaternion"][:, k]) for k, name in enumerate("wxyz"))
    assert all(np.array_equal(curves(rates)[rf"$\omega_{name}$"], run["angular_velocity"][:, k]) for k, name in enumerate("xyz"))
    velocity = run["angular_velocity_space"]
    np.testing.assert_allclose(np.transpose([curves(spin_axis)[name] for name in "XYZ"]), velocity / np.linalg.norm(velocity, axis=1, keepdims=True), atol=1e-12)
    assert {"drift of energy", "drift of orthogonality", "error of the attitude"} <= set(legend(accuracy)) and legend(attitude) == list("wxyz")
    days = {**SPACECRAFT, "step": 3600, "members": 2, "body": {"moments": [3, 2, 1], "angular_velocity": [[2e-5, 2e-4, 1e-5], [1e-5, 2e-4, 0]]}}
    many = stiefel.simulate(days, to=240, every=1)
    axes, = many.plot(["rates"], member=1).axes
    assert np.array_equal(curves(axes)[r"$\omega_x$"], many["angular_velocity"][:, 1, 0]) and axes.get_xlabel() == "time (days)"


def test_a_polhode_is_on_its_sphere(run):
    """Its points are those of the samples, turned towards the viewer; each visible one is drawn at full strength."""
    axes, = run.polhode().axes
    momenta = run["angular_velocity"] * [1200, 900, 500]
    u = (momenta / np.linalg.norm(momenta, axis=1, keepdims=True))[:, [2, 1, 0]]  # moments in ascending order
    x, y, depth = sphere._view(0.6, 0.9) @ u.T
    front, seen = next(line for line in axes.lines if line.get_label() == "polhode"), depth >= 0
    assert 0.2 < seen.mean() < 1 and np.allclose(front.get_xdata()[seen], x[seen]) and np.allclose(front.get_ydata()[seen], y[seen])
    assert legend(axes) == ["separatrix", "polhode", "start"]
    moments = np.array([1.0, 2.0, 5.0])
    for curve in [*sphere.separatrix(moments), *sphere.other_polhodes(moments)]:
        assert np.allclose(np.sum(curve**2, axis=1), 1) and np.ptp(np.sum(curve**2 / moments, axis=1)) < 1e-12


@pytest.mark.parametrize("name", FRAMES)
def test_frames_in_three_coordinates(client, run, name):
    with client.create(name) as session:
        shown = session.trajectory(to=30)
    axes, = shown.plot3d(coordinates=(2, 0, 1)).axes
    first = {"ellipsoid": lambda: shown["q"], "stiefel": lambda: shown["Q"][:, 0], "rigid_body_8": lambda: shown["Q"][:, :, 0]}[name]()
    assert legend(axes) == FRAMES[name] and np.array_equal(np.transpose(axes.lines[0].get_data_3d()), first[:, [2, 0, 1]])
    body, = run.plot3d().axes
    assert legend(body) == ["body x", "body y", "body z"] and body.get_xlabel() == "space X"
    assert np.allclose(np.transpose(body.lines[0].get_data_3d()), run.as_rotation().as_matrix()[:, :, 0], rtol=0, atol=1e-15)


def test_what_cannot_be_drawn_is_refused(client, run):
    with client.create("double_bracket") as session:
        complex_ = session.trajectory(to=3)
    rest = stiefel.simulate({**SPACECRAFT, "body": {"moments": [1, 2, 3], "angular_velocity": [0, 0, 0]}}, to=1)
    for picture, said in ((complex_.plot3d, "complex"), (complex_.polhode, "no momentum"), (rest.polhode, "at rest"),
                          (lambda: run.plot(["attitudes"]), "panels: .*must be among attitude, rates"), (lambda: run.plot([]), "panels"),
                          (lambda: run.plot3d(coordinates=(0, 1, 90)), "coordinates: .*must be three of 0 to")):
        with pytest.raises(ValueError, match=said):
            picture()


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
    axes = tradeoff.plot(cost="work", error="error")
    drawn = {tuple(point) for line in axes.lines for point in np.asarray(line.get_xydata())}
    assert {(point.work, max(point.error, known)) for point in reached} <= drawn
    assert list(curves(axes)["Pareto front: no point beats these in both"]) == [max(point.error, known) for point in tradeoff.front]
    with pytest.raises(ValueError, match="cost: 'money'"):
        tradeoff.plot(cost="money")
    frame = pytest.importorskip("pandas") and tradeoff.to_dataframe()
    assert frame.attrs["horizon"] == 4.0 and list(frame["work"]) == [point.work for point in tradeoff.points] and frame["front"].sum() == len(tradeoff.front)
    assert diagram.pareto_front([(3, 1), (1, 2), (2, 3), (4, 0.5), (4, 0.7)]) == [(1, 2), (3, 1), (4, 0.5)]


def test_sections_and_exponents(client):
    scene = {"system": "ellipsoid", "inertia": [1, 2, 3], "step": 0.05, "members": 2, "method": {"name": "variational"},
             "initial": {"q": [[[1, 0, 0]], [[0, 1, 0]]], "qdot": [[[0, 1, 0.3]], [[1, 0, 0.5]]]}}
    with client.create(scene) as session:
        section = session.poincare({"q": [0, 0, 1]}, to=500, coordinates=[{"q": [1, 0, 0]}, lambda s: s.time])
    for member, line in enumerate(section.plot(x=1, y=0, markersize=4).lines):
        np.testing.assert_array_equal(line.get_xydata(), section.points[section.member == member][:, [1, 0]])
    with pytest.raises(ValueError, match="x, y: 0, 2: must be columns of points, of which there are 2"):
        section.plot(x=0, y=2)
    with client.create({**SPACECRAFT, "method": {"name": "variational"}}) as session:
        spectrum = session.lyapunov(to=4000, every=500, count=2)
    axes = spectrum.plot()
    assert legend(axes) == [r"$\lambda_{1}$", r"$\lambda_{2}$"]
    np.testing.assert_array_equal(curves(axes)[r"$\lambda_{2}$"], spectrum.history[:, 1])
