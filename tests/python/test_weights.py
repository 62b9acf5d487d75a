"""The tool that counts weights adds what the table lacks and leaves the rest as it is."""
from __future__ import annotations

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "bench"))

import weights  # noqa: E402

HEUN = ("rigid_body", "heun", 2, "plain", "double")
COUNTED = weights.Row([(3, 3, 411.0), (4, 4, 5210.0)], [(3, 0.01, 0.5), (3, 0.1, 1.0)])


def test_the_table_reads_back():
    text = weights.TABLE.read_text()
    assert weights.table(weights.read(text)) == text


def test_only_missing_rows_are_added():
    used = weights.read(weights.TABLE.read_text())
    counted = {key: weights.Row([(n, N, 2 * w) for n, N, w in row.sizes], row.rates) for key, row in used.items()}
    after = max(k for k, key in enumerate(counted) if key[0] == "rigid_body") + 1
    keys = list(counted)
    counted = {key: COUNTED if key == HEUN else counted[key] for key in [*keys[:after], HEUN, *keys[after:]]}
    written = weights.read(weights.with_missing(used, counted))
    assert list(written).index(HEUN) == after
    assert written.pop(HEUN) == COUNTED
    assert written == used


def test_rows_that_were_not_counted_stay():
    used = weights.read(weights.TABLE.read_text())
    assert weights.read(weights.with_missing(used, {HEUN: COUNTED})) == {HEUN: COUNTED, **used}


def test_sizes_and_rates_of_a_row_in_use_stay():
    counted = {HEUN: weights.Row([(4, 4, 1.0), (5, 5, 8000.0)], [(3, 0.01, 9.0)])}
    for used in (COUNTED, COUNTED._replace(rates=[])):
        assert weights.read(weights.with_missing({HEUN: used}, counted)) == {HEUN: used}
