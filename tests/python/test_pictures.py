"""The pictures: no colour is lost, curves stay apart without colours, names stand at the ends of their curves."""
import itertools
import sys
from pathlib import Path
from types import SimpleNamespace

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.colors import to_hex, to_rgb
from matplotlib.figure import Figure
from PIL import Image

from stiefel import diagram

ROOT = Path(__file__).parents[2]
sys.path[:0] = [str(ROOT / "client/examples"), str(ROOT / "tests/bench")]
import picture as examples  # noqa: E402
from peers import picture as peers  # noqa: E402


@pytest.fixture
def figures(monkeypatch):
    """The figures that are saved, kept open."""
    saved = []
    save = Figure.savefig
    monkeypatch.setattr(plt, "close", lambda figure: None)
    monkeypatch.setattr(Figure, "savefig", lambda figure, *a, **k: (saved.append(figure), save(figure, *a, **k))[1])
    yield saved
    monkeypatch.undo()
    plt.close("all")


def colours_of(path):
    with Image.open(path) as image:
        return {to_hex(np.array(pixel) / 255) for _, pixel in image.convert("RGB").getcolors(1 << 24)}


def linear(colour):
    c = np.array(to_rgb(colour))
    return np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055)**2.4)


def lightness_and_hue(rgb):
    """CIE L*a*b* of linear RGB."""
    to_xyz = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
    x, y, z = np.cbrt(np.clip(to_xyz @ rgb / [0.9505, 1, 1.089], 0.008856, None))
    return np.array([116 * y - 16, 500 * (x - y), 200 * (y - z)])


# Viénot, Brettel and Mollon 1999: what a protanope sees of linear RGB.
PROTANOPIA = np.array([[0.11238, 0.88762, 0], [0.11238, 0.88762, 0], [0.00401, -0.00401, 1]])


def test_curves_beside_each_other_differ_in_protanopia_or_in_everything_else():
    for j, k in itertools.combinations(range(11), 2):
        one, other = diagram.style(j), diagram.style(k)
        assert one["marker"] != other["marker"]
        seen = [lightness_and_hue(PROTANOPIA @ linear(look["color"])) for look in (one, other)]
        assert np.linalg.norm(seen[0] - seen[1]) > 10 or one["linestyle"] != other["linestyle"], (j, k)
    looks = [tuple(map(str, diagram.style(k).values())) for k in range(330)]
    assert len(set(looks)) == 330


class Run:
    time = np.linspace(0, 3 * 86400, 50)

    def __getitem__(self, name):
        return np.cos(np.arange(9).reshape(1, 3, 3) + self.time[:, None, None] / 40000)


def test_a_scene_loses_no_colour(figures, tmp_path):
    drifts = {f"family {k}": 10.0**-(k + np.arange(50) / 20) for k in range(7)}
    examples.scene(tmp_path / "scene.png", "title", Run(), "Q", Run.time, drifts)
    lines = [line for axes in figures[0].axes for line in axes.lines]
    assert len(lines) == 16
    assert {to_hex(line.get_color()) for line in lines} <= colours_of(tmp_path / "scene.png")
    assert len({(line.get_color(), line._unscaled_dash_pattern) for line in lines[:9]}) == 9
    assert (tmp_path / "scene.png").stat().st_size < 300_000


def test_toutatis_is_read_without_colours(figures, tmp_path):
    observations = [SimpleNamespace(step=86400 * k, observed=Run()["Q"][k]) for k in range(3)]
    found = {name: SimpleNamespace(method=name, days=Run.time / 86400, drift=1e-9 * Run.time, error=1e-6 * Run.time)
             for name in ("recommended", "variational", "rk4")}
    examples.toutatis(tmp_path / "t.png", Run(), observations, found)
    for panel in figures[0].axes[:3]:
        curves, marks = panel.lines[::2], panel.lines[1::2]
        assert len({line._unscaled_dash_pattern for line in curves}) == len({m.get_marker() for m in marks}) == 3
    for panel, words in zip(figures[0].axes[3:], ("energy drift", "error of the attitude"), strict=True):
        assert len({line._unscaled_dash_pattern for line in panel.lines}) == 3
        assert panel.get_title(loc="left").startswith(words)
    used = {to_hex(line.get_color()) for axes in figures[0].axes for line in axes.lines}
    assert used <= colours_of(tmp_path / "t.png")


# Labels


def texts_within(axes):
    axes.figure.canvas.draw()
    renderer = axes.figure.canvas.get_renderer()
    boxes = [diagram._text_box(label, renderer) for label in axes.texts]
    frame = axes.get_window_extent()
    assert all(frame.x0 <= b.x0 and b.x1 <= frame.x1 and frame.y0 <= b.y0 and b.y1 <= frame.y1 for b in boxes)
    assert not any(one.overlaps(other) for one, other in itertools.combinations(boxes, 2))


@pytest.mark.parametrize("spread", [1.0, 0.01, 0.0])
def test_names_keep_off_each_other_however_near_the_ends(spread):
    figure, axes = plt.subplots(figsize=(9, 6))
    axes.set(xlim=(0, 1), ylim=(0, 1))
    rng = np.random.default_rng(1)
    ends = [diagram.End(0.3 + 0.2 * spread * a, 0.5 + 0.4 * spread * b, f"method {k} of a long name", "black")
            for k, (a, b) in enumerate(rng.uniform(-1, 1, (10, 2)))]
    diagram.label_ends(axes, ends)
    assert sorted(label.get_text() for label in axes.texts) == sorted(end.text for end in ends)
    texts_within(axes)
    plt.close(figure)


def test_a_name_keeps_off_the_curves():
    figure, axes = plt.subplots(figsize=(9, 6))
    axes.set(xlim=(0, 1), ylim=(0, 1))
    curve = [(0.2, 0.5), (0.9, 0.5)]
    diagram.label_ends(axes, [diagram.End(0.3, 0.5, "on the line", "black")], [curve])
    box = diagram._text_box(axes.texts[0], figure.canvas.get_renderer())
    y = axes.transData.transform((0.3, 0.5))[1]
    assert not box.y0 < y < box.y1
    plt.close(figure)


def test_the_better_curve_beats_more():
    corner = (100.0, 1.0)
    assert diagram.dominated_area([(1, 1e-3), (10, 1e-6)], corner) > diagram.dominated_area([(2, 1e-3), (10, 1e-6)], corner)
    assert diagram.dominated_area([(10, 1e-6), (1, 1e-3)], corner) == pytest.approx(
        np.log(100) * np.log(1e3) + np.log(10) * np.log(1e3))
    assert diagram.dominated_area([(200, 1e-9), (1, 2)], corner) == 0
    assert diagram.pareto_front([(3, 1), (1, 2), (2, 3), (4, 0.5), (4, 0.7)]) == [(1, 2), (3, 1), (4, 0.5)]


# The peers


def contest():
    contestants, curves = [], {}

    def add(title, package, cost, order, floor=1e-13):
        contestants.append({"title": title, "package": package})
        curves[title] = [{"seconds": cost * 2**(k / 2), "attitude": max(floor, 2 * 2**(-order * k / 2))} for k in range(12)]

    for arithmetic, factor, floor in (("plain", 1.0, 1e-11), ("compensated", 1.5, 1e-13)):
        for order in (2, 4, 6, 8):
            add(f"variational {order}, {arithmetic}", "stiefel", 1e-3 * order * factor, order, floor)
        add(f"rk4, {arithmetic}", "stiefel", 2e-3 * factor, 4, floor)
    add("odeint fehlberg78", "odeint", 1e-3, 8)
    add("odeint bulirsch_stoer", "odeint", 3e-3, 6)
    add("SciPy solve_ivp DOP853", "SciPy", 0.2, 8)
    add("MuJoCo RK4, rollout", "MuJoCo", 0.2, 4)
    return {"target": 1e-10, "rotations": 1000, "contestants": contestants,
            "bodies": {"box": {"curves": curves}, "other": {"curves": {**curves, "rk4, plain": []}}}}


def test_of_each_family_of_the_peers_the_best_has_a_colour_and_a_name(figures, tmp_path):
    data = contest()
    peers.draw(data, {"machine": "m", "commit": "c", "build": "b"}, tmp_path / "peers.png")
    assert (tmp_path / "peers.png").stat().st_size < 300_000
    for axes in figures[0].axes:
        names = sorted(label.get_text() for label in axes.texts)
        assert len(names) == 4 and names[:2] == ["SciPy solve_ivp DOP853", "odeint fehlberg78"]
        assert [name.split()[0].rstrip(",") for name in names[2:]] == ["rk4", "variational"]
        texts_within(axes)
        curves = [line for line in axes.lines if len(line.get_xdata()) > 2]
        front = next(line for line in curves if line.get_zorder() > 5)
        coloured = [line for line in curves if line is not front and to_hex(line.get_color()) != to_hex(diagram.GREY)]
        assert len(coloured) == 4
        assert front.get_zorder() == max(line.get_zorder() for line in axes.lines)
        drawn = [tuple(point) for line in curves if line is not front for point in line.get_xydata()]
        assert [tuple(point) for point in front.get_xydata()] == diagram.pareto_front(drawn)
    assert {to_hex(line.get_color()) for line in coloured} <= colours_of(tmp_path / "peers.png")
