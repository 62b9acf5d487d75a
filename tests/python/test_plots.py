"""Figures of trajectories: their curves are the data, and what they refuse."""
import re

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import pytest

import stiefel
from stiefel._report import page, run_data
from stiefel._results import body, sphere


def tumbling(moments, angular_velocity, **more):
    return {"system": "rigid_body", "step": 1, "body": {"moments": moments, "angular_velocity": angular_velocity}, **more}


SPACECRAFT = tumbling([1200, 900, 500], [0.002, 0.06, 0.001])
TENSOR = [17023.3, 124825.7, 129112.2, 397.1, -2171.4, 344.2]


@pytest.fixture(autouse=True)
def closed():
    yield
    plt.close("all")


@pytest.fixture(scope="module")
def run(client):
    with client.create(SPACECRAFT) as session:
        return session.trajectory(to=700)


def curves(axes):
    return {line.get_label(): line.get_ydata() for line in axes.lines}


def test_the_default_is_attitude_rates_and_accuracy(run, client):
    figure = run.plot()
    attitude, rates, accuracy = figure.axes
    for k, name in enumerate("wxyz"):
        assert np.array_equal(curves(attitude)[name], run["quaternion"][:, k])
    for k, name in enumerate("xyz"):
        assert np.allclose(curves(rates)[rf"$\omega_{name}$"], run["angular_velocity"][:, k], atol=1e-16)
    assert {"drift of energy", "drift of orthogonality", "error of the attitude"} <= set(curves(accuracy))
    assert accuracy.get_yscale() == "log" and accuracy.get_xlabel() == "time (s)"
    with client.create(SPACECRAFT) as session:
        last = session.diagnose(to=700, invariants="energy")
    assert curves(accuracy)["drift of energy"][-1] == max(last.invariants[0].drift, 2.0**-53)


def test_drift_and_error_come_from_the_server_of_the_process_too():
    run = stiefel.simulate(SPACECRAFT, to=50)
    figure = run.plot(["accuracy"], to=20)
    assert max(figure.axes[0].lines[0].get_xdata()) == 20


def test_a_notebook_shows_a_figure_once(run, monkeypatch):
    """It shows what pyplot holds, and the value of a cell besides."""
    own = plt.figure()
    run.plot(figure=own), run.polhode(), run.plot3d()
    assert len(plt.get_fignums()) == 3
    plt.close("all")
    monkeypatch.setattr(plt, "get_backend", lambda: "module://matplotlib_inline.backend_inline")
    own = plt.figure()
    for figure in (run.plot(figure=own), run.plot(), run.polhode(), run.plot3d()):
        assert figure.axes and plt.get_fignums() == [own.number]


def test_the_spin_axis_is_a_unit_vector_in_space(run, client):
    axes, = run.plot(["spin_axis"]).axes
    axis = np.stack([curves(axes)[name] for name in "XYZ"], axis=1)
    assert np.allclose(np.linalg.norm(axis, axis=1), 1)
    with client.create(SPACECRAFT) as session:
        velocity = session.trajectory(to=700, fields=["angular_velocity_space"])["angular_velocity_space"]
    assert np.allclose(axis, velocity / np.linalg.norm(velocity, axis=1, keepdims=True), atol=1e-12)


def test_a_panel_that_the_fields_do_not_have_is_refused(run, client):
    with client.create(SPACECRAFT) as session:
        rates = session.trajectory(to=5, fields=["angular_velocity"])
    assert run.panels == ("attitude", "rates", "spin_axis", "polhode", "accuracy") and "attitude" not in rates.panels
    for panels in (["attitude"], ["spin_axis"], ["colour"], []):
        with pytest.raises(ValueError, match="panels: .*must be among rates, polhode, accuracy"):
            rates.plot(panels)
    assert plt.get_fignums() == []


def test_days_where_seconds_are_too_many(client):
    with client.create(tumbling([1200, 900, 500], [2e-5, 2e-4, 1e-5], step=3600)) as session:
        run = session.trajectory(to=240)
    figure = run.plot(["rates"])
    figure.canvas.draw()
    assert figure.axes[0].get_xlabel() == "time (days)"
    labels = {label.get_text(): tick for tick, label in zip(figure.axes[0].get_xticks(), figure.axes[0].get_xticklabels())}
    assert labels["4"] == 4 * 86400


@pytest.mark.parametrize("scene", [
    {"inertia_tensor": TENSOR, "angular_velocity": [0.0048, 0.0019, 0.0273]},
    {"moments": [3, 1, 2], "angular_velocity": [0.1, 1, 0.2]},
])
def test_momenta_and_principal_axes(client, scene):
    with client.create({"system": "rigid_body", "step": 0.5, "body": scene}) as session:
        run = session.trajectory(to=40, fields=["quaternion", "angular_velocity", "momentum_space", "M", "Q"])
    inertia = body.principal(run.scene, None)
    assert np.allclose(inertia.axes @ inertia.axes.T, np.eye(3)) and (np.diff(inertia.moments) > 0).all()
    momenta = body.momenta(run.scene, run, None)
    for attitudes in (body.attitudes(run.scene, run, None), run["Q"]):
        in_space = np.einsum("sij,sj->si", attitudes, momenta)
        assert np.allclose(in_space, run["momentum_space"], rtol=0, atol=1e-9 * abs(momenta).max())
    assert np.allclose(inertia.velocity(momenta), run["angular_velocity"], rtol=1e-9, atol=1e-12)


def test_systems_of_other_variables_have_the_same_attitude(client):
    """The frame of a right-invariant body is the transpose, and its momentum has the other sign."""
    M = [[0, -3, 2], [3, 0, -1], [-2, 1, 0]]
    found = []
    for system, sign in (("rigid_body", 1), ("right_rigid_body", -1)):
        scene = {"system": system, "inertia": [1, 2, 3], "step": 0.1, "method": {"name": "adaptive"},
                 "initial": {"Q": np.eye(3), "M": sign * np.array(M)}}
        with client.create(scene) as session:
            run = session.trajectory(to=30, fields=["Q", "M"])
        found.append((body.attitudes(run.scene, run, None), body.momenta(run.scene, run, None)))
    for left, right in zip(*found):
        assert np.allclose(left, right, atol=1e-9)


def test_the_polhode_is_on_its_sphere(run):
    """Its points are those of the samples, turned towards the viewer; each visible one is drawn at full strength."""
    figure = run.polhode()
    axes, = figure.axes
    momenta = run["angular_velocity"] * [1200, 900, 500]
    u = (momenta / np.linalg.norm(momenta, axis=1, keepdims=True))[:, [2, 1, 0]]  # moments in ascending order
    x, y, depth = sphere._view((0.6, 0.9)) @ u.T
    front = next(line for line in axes.lines if line.get_linewidth() == 1.8 and line.get_alpha() == 1)
    seen = depth >= 0
    assert 0.2 < seen.mean() < 1
    assert np.allclose(front.get_xdata()[seen], x[seen]) and np.allclose(front.get_ydata()[seen], y[seen])
    assert {text.get_text() for text in axes.texts} >= {"+x", "+y", "+z"}
    assert run.polhode(plt.figure().add_subplot()) is plt.gcf()


def test_separatrix_and_other_polhodes_have_one_energy_each():
    moments = np.array([1.0, 2.0, 5.0])
    for curve in sphere._separatrix(moments):
        assert np.allclose(np.sum(curve**2, axis=1), 1) and np.allclose(np.sum(curve**2 / moments, axis=1), 1 / 2)
    levels = set()
    for curve in sphere._other_polhodes(moments):
        energies = np.sum(curve**2 / moments, axis=1)
        assert np.allclose(np.sum(curve**2, axis=1), 1) and np.ptp(energies) < 1e-12
        levels.add(round(float(energies[0]), 9))
    assert len(levels) == 6 and min(levels) > 1 / 5 and max(levels) < 1


def test_a_body_at_rest_has_no_polhode(client):
    with client.create(tumbling([1, 2, 3], [0, 0, 0])) as session:
        with pytest.raises(ValueError, match="at rest"):
            session.trajectory(to=3).polhode()


@pytest.mark.parametrize("moments", [[1, 1, 2], [2, 2, 2]])
def test_equal_moments_have_no_separatrix(client, moments):
    with client.create(tumbling(moments, [0.1, 0.2, 0.3])) as session:
        figure = session.trajectory(to=30).polhode()
    assert not any(line.get_color() == "black" for line in figure.axes[0].lines)
    figure.canvas.draw()


def test_a_member_of_an_ensemble(client):
    velocities = np.array([[0.3, 1, 0.2], [0.1, 1, 0.1]])
    with client.create(tumbling([1, 2, 3], velocities, members=2, step=0.1)) as session:
        run = session.trajectory(to=20)
    for member in (0, 1):
        rates = run.plot(["rates"], member=member).axes[0]
        assert np.allclose(curves(rates)[r"$\omega_x$"], run["angular_velocity"][:, member, 0])


@pytest.mark.parametrize("name, labels", [
    ("stiefel", ["row 0", "row 1"]), ("ellipsoid", ["q"]), ("rigid_body_8", [f"column {k}" for k in range(6)])])
def test_frames_in_three_coordinates(client, name, labels):
    with client.create(name) as session:
        run = session.trajectory(to=30)
    figure = run.plot3d(coordinates=(2, 0, 1))
    axes, = figure.axes
    assert [text.get_text() for text in axes.get_legend().get_texts()] == labels
    frames = run["q"][:, None] if name == "ellipsoid" else run["Q"]
    first = axes.lines[0].get_data_3d()
    expected = frames[:, 0] if name != "rigid_body_8" else frames[:, :, 0]
    assert np.array_equal(np.transpose(first), expected[:, [2, 0, 1]])
    assert axes.get_xlabel() == "coordinate 2"
    with pytest.raises(ValueError, match="coordinates: .*must be three of 0 to"):
        run.plot3d(coordinates=(0, 1, 90))


@pytest.mark.parametrize("system, fields", [("rigid_body", "Q"), ("rigid_body", "quaternion"), ("right_rigid_body", "Q")])
def test_a_body_has_axes_x_y_z_in_space(client, system, fields):
    scene = SPACECRAFT if fields == "quaternion" else {"system": system, "step": 0.1, "inertia": [1, 2, 3], "initial": {
        "Q": np.eye(3), "M": [[0, -1, 2], [1, 0, -3], [-2, 3, 0]]}}
    with client.create(scene) as session:
        run = session.trajectory(to=30, fields=fields)
    axes, = run.plot3d().axes
    assert [text.get_text() for text in axes.get_legend().get_texts()] == ["body x", "body y", "body z"]
    assert (axes.get_xlabel(), axes.get_ylabel(), axes.get_zlabel()) == ("space X", "space Y", "space Z")
    if fields == "Q":
        attitudes = run["Q"] if system == "rigid_body" else run["Q"].transpose(0, 2, 1)  # there Q takes space to body
        assert np.allclose(np.transpose(axes.lines[0].get_data_3d()), attitudes[:, :, 0], rtol=0, atol=1e-15)


def test_principal_axes_that_are_not_the_scene_s_say_where_they_are(client):
    with client.create({"system": "rigid_body", "step": 0.1, "body": {
            "inertia_tensor": [4, 5, 3, 0.3, -0.2, 0.1], "angular_velocity": [0.1, 1, 0.2]}}) as session:
        text = session.trajectory(to=10).polhode().axes[0].texts[-1].get_text()
    moments, columns = np.linalg.eigh([[4, 0.3, -0.2], [0.3, 5, 0.1], [-0.2, 0.1, 3]])
    found = re.findall(r"([abc]) = \((\S+), (\S+), (\S+)\) in body axes x, y, z", text)
    assert [name for name, *_ in found] == ["a", "b", "c"]
    shown = np.array([numbers for _, *numbers in found], float)
    assert np.allclose(abs(np.sum(shown.T * columns, axis=0)), 1, atol=2e-3) and np.linalg.det(shown) > 0.99


@pytest.mark.parametrize("dearest, least, most", [(1.0, 2, 2), (1e30, 21, 21)])
def test_an_error_is_a_curve_however_dear(client, monkeypatch, dearest, least, most):
    monkeypatch.setattr(run_data, "DEAREST", dearest)
    with client.create("stiefel") as session:
        run = run_data.accuracy(session, 100)
    assert least <= len(run.error_time) <= most and run.error_time[0] == 0 and run.error_time[-1] == run.horizon
    assert len(run.errors["attitude"]) == len(run.error_time)


def test_a_report_measures_error_against_cost_at_its_own_end(client):
    with client.create("tumbling_spacecraft") as session:
        for to in (40, 120):
            shown = page.data(session, to, estimate_error=False)
            assert shown["tradeoff"]["horizon"] == shown["horizon"] == to * session.scene["step"]


@pytest.mark.parametrize("name", ["toutatis", "rigid_body_8", "stiefel"])
def test_nothing_is_cut_off_at_the_edges(client, name):
    with client.create(name) as session:
        run = session.trajectory(to=30)
    figures = [run.plot(), run.plot3d(), *([run.polhode()] if name == "toutatis" else [])]
    for figure in figures:
        figure.canvas.draw()
        drawn = figure.bbox.padded(1)
        texts = [text for axes in figure.axes for text in (*axes.texts, axes.title, axes._left_title)]
        for artist in (*texts, *filter(None, (axes.get_legend() for axes in figure.axes))):
            box = artist.get_window_extent()
            assert drawn.x0 <= box.x0 and box.x1 <= drawn.x1 and drawn.y0 <= box.y0 and box.y1 <= drawn.y1, artist


def test_what_has_no_real_frame_is_refused(client):
    with client.create("double_bracket") as session:
        run = session.trajectory(to=3)
    with pytest.raises(ValueError, match="complex"):
        run.plot3d()
    with pytest.raises(ValueError, match="no momentum"):
        run.polhode()
    drawn = curves(run.plot(["rates"]).axes[0])
    assert len(drawn) == 6 and all(name[:5] in ("Re P[", "Im P[") for name in drawn)


def test_curves_can_be_told_apart_in_grey(run):
    """No two curves of a panel share dashes and marks."""
    for axes in run.plot().axes:
        looks = [(line.get_linestyle(), line.get_marker(), tuple(line._dash_pattern[1] or ())) for line in axes.lines]
        assert len(set(looks)) == len(looks)


def test_a_report_of_a_trajectory(run, tmp_path):
    run.report(tmp_path / "run.html", name="a body", tradeoff=False)
    text = (tmp_path / "run.html").read_text(encoding="utf-8")
    assert '"name":"a body"' in text and '"to":700' in text and '"tradeoff":null' in text
    stiefel.simulate(SPACECRAFT, to=20).report(tmp_path / "own.html", estimate_error=False)
    own = (tmp_path / "own.html").read_text(encoding="utf-8")
    assert '"front":true' in own and '"last":null' in own
