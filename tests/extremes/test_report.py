"""The report distinguishes rounding, truncation and kept invariants, and counts no vacuous bound as held."""
import json
import pathlib
import subprocess
import sys

REPORT = pathlib.Path(__file__).parent / "report"


def record(measure, value, bound, **more):
    return {"extreme": "separatrix", "row": "first flip", "system": "rigid_body", "method": "variational", "order": 2,
            "arithmetic": "compensated", "precision": "double", "outcome": "REACHED", "measure": measure,
            "value": value, "bound": bound, "why": "100 κ u √steps", "seconds": 0.25, "limit": None} | more


def rendered(tmp_path, records):
    (tmp_path / "separatrix.jsonl").write_text("".join(json.dumps(r) + "\n" for r in records))
    subprocess.run([sys.executable, REPORT, tmp_path, "--output", tmp_path], check=True)
    return (tmp_path / "REPORT.md").read_text()


def cells(text, row):
    (line,) = [line for line in text.splitlines() if line.startswith(f"| {row} |")]
    return [cell.strip() for cell in line.strip("|").split("|")]


def test_rounding_and_truncation_have_columns_of_their_own(tmp_path):
    text = rendered(tmp_path, [
        record("rounding", 3e-15, 1e-13), record("truncation", 6e-6, "inf", why="no bound"),
        record("drift", 2e-16, 1e-14), record("orthogonality", 9e-15, 1e-14),
        record("rounding", 5e-14, 1e-12, arithmetic="plain"), record("truncation", 6e-6, "inf", arithmetic="plain"),
        record("drift", 1e-13, 1e-12, arithmetic="plain")])
    assert cells(text, "first flip") == [
        "first flip", "`variational`", "3.0e-15 ≤ 1.0e-13", "5.0e-14 ≤ 1.0e-12", "6.0e-06",
        "orthogonality 9.0e-15 ≤ 1.0e-14", "drift 1.0e-13 ≤ 1.0e-12", "100 κ u √steps", "0.5"]
    assert "7 measurements: 5 within their bounds, 0 known limits, 2 without a bound." in text


def test_a_bound_that_nothing_can_miss_is_none(tmp_path):
    text = rendered(tmp_path, [record("rounding", 1.5, 4.0), record("drift", 1e-16, 1e-14)])
    assert cells(text, "first flip")[2] == "1.5e+00, no bound"
    assert "2 measurements: 1 within their bounds, 0 known limits, 1 without a bound." in text


def test_a_miss_is_shown_and_counted(tmp_path):
    text = rendered(tmp_path, [record("rounding", 2e-13, 1e-13), record("rounding", 1e-3, 1e-13, row="rod",
                                                                        limit="the rod is too thin")])
    assert cells(text, "first flip")[2] == "2.0e-13 > 1.0e-13"
    assert "2 measurements: 0 within their bounds, 1 known limits, 0 without a bound, **1 missed**." in text
    assert "- the rod is too thin (`variational`: separatrix, rod)." in text


def test_truncation_is_shown_of_the_lowest_and_the_highest_order(tmp_path):
    text = rendered(tmp_path, [record("rounding", 1e-16, 1e-13, order=order) for order in (2, 4, 8)] +
                    [record("truncation", 10.0**-order, "inf", order=order) for order in (2, 4, 8)])
    assert cells(text, "first flip")[4] == "1.0e-02 (order 2) … 1.0e-08 (order 8)"
