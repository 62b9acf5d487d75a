"""Names stand at the ends of their curves and cover nothing; the best curve is the one that beats most."""
import itertools

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import pytest

from stiefel._results import diagram


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


def test_the_better_curve_beats_more():
    corner = (100.0, 1.0)
    assert diagram.dominated_area([(1, 1e-3), (10, 1e-6)], corner) > diagram.dominated_area([(2, 1e-3), (10, 1e-6)], corner)
    assert diagram.dominated_area([(10, 1e-6), (1, 1e-3)], corner) == pytest.approx(
        np.log(100) * np.log(1e3) + np.log(10) * np.log(1e3))
    assert diagram.dominated_area([(200, 1e-9), (1, 2)], corner) == 0
    assert diagram.pareto_front([(3, 1), (1, 2), (2, 3), (4, 0.5), (4, 0.7)]) == [(1, 2), (3, 1), (4, 0.5)]
