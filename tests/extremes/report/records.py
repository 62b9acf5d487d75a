"""Reads the records of the tests: one JSON object per line, with the fields of `Record` (extremes.h)."""
from __future__ import annotations

import json
import math

# Relative errors. An error of 1 is as large as the quantity itself, so that a bound of 1 or more requires no digit.
RELATIVE = {"rounding", "truncation", "error", "drift", "orthogonality"}


def read(folder):
    records = []
    for path in sorted(folder.glob("*.jsonl")):
        for line in path.read_text().splitlines():
            record = json.loads(line)
            record["value"] = float(record["value"])
            record["bound"] = math.inf if record["bound"] is None else float(record["bound"])
            records.append(record)
    return records


def bounded(record):
    """Returns whether a value could miss the bound."""
    return record["bound"] < (1 if record["measure"] in RELATIVE else math.inf)


def fraction(record):
    """Returns the part of its bound that a record uses; for a bound of 0, either 0 or infinity."""
    value, bound = record["value"], record["bound"]
    if math.isnan(value):
        return math.inf
    if bound == 0:
        return 0 if value <= 0 else math.inf
    return value / bound


def counted(records):
    """Returns a sentence with the numbers of measurements that hold, are known limits, have no bound, or miss it."""
    limits = sum(bool(r["limit"]) for r in records)
    free = sum(not r["limit"] and not bounded(r) for r in records)
    missed = sum(not r["limit"] and bounded(r) and fraction(r) > 1 for r in records)
    held = len(records) - limits - free - missed
    text = f"{len(records)} measurements: {held} within their bounds, {limits} known limits, {free} without a bound"
    return text + (f", **{missed} missed**." if missed else ".")


def number(x):
    if math.isfinite(x) and x == int(x) and abs(x) < 1e6:
        return str(int(x))
    return f"{x:.1e}"


def method(record):
    name = record["method"] or record["system"]
    return f"`{name}`" if name else ""
