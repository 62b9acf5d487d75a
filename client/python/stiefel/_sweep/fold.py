"""Combines the statistics of all motions of a sweep in one, where `over_members` asks for it.

This is done where the sweep was called, in the row-major order of the points, so that the bits do not depend on how the
points were divided into chunks.
"""
from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stiefel import v1 as pb
from stiefel.errors import InvalidArgument, Violation

SAMPLES = "samples"
#: The statistics that follow from those of the members.
FOLDED = ("min", "max", "mean", "rms", "sign_changes", "drift", "histogram")


def check(quantity: pb.Quantity, place: str) -> None:
    """Raises InvalidArgument if a statistic of a quantity over all members does not follow from those of the members."""
    asked = [pb.Statistic.Name(number)[len("STATISTIC_"):].lower() for number in quantity.statistics]
    wrong = [name for name in [*asked, *(["quantiles"] if quantity.quantiles else [])] if name not in FOLDED]
    if wrong:
        rule = (f"over_members: {wrong[0]} does not follow from that of each motion: must be one of {', '.join(FOLDED)}, "
                f"or reduce the arrays that come home")
        raise InvalidArgument(f"{place}: {rule}", (Violation(place, rule),))


def per_member(request: pb.SummarizeRequest) -> pb.SummarizeRequest:
    """Returns the request that workers get, for statistics of each member."""
    asked = pb.SummarizeRequest()
    asked.CopyFrom(request)
    for quantity in asked.quantities:
        quantity.ClearField("over_members")
    return asked


def over_points(request: pb.SummarizeRequest, arrays: Mapping[str, NDArray[Any]],
                computed: NDArray[np.bool_]) -> dict[str, NDArray[Any]]:
    """Returns the statistics over all points that are `computed` and have a sample, by the names of the arrays that they
    replace. Each array is (points, ...), and its statistic is (...)."""
    folded = {quantity.name for quantity in request.quantities if quantity.over_members}
    if not folded:
        return {}
    counts = arrays[SAMPLES]
    there = computed & (counts > 0)
    return {name: _fold(name.rpartition(".")[2], values[there], counts[there]) for name, values in arrays.items()
            if name.rpartition(".")[0] in folded}


def _fold(statistic: str, values: NDArray[Any], counts: NDArray[Any]) -> NDArray[Any]:
    if statistic in ("sign_changes", "histogram"):
        return np.asarray(values.sum(axis=0, dtype=values.dtype))
    if not len(values):
        return np.full(values.shape[1:], np.nan, values.dtype)
    if statistic == "min":
        return np.asarray(values.min(axis=0))
    if statistic in ("max", "drift"):
        return np.asarray(values.max(axis=0))
    # The sum of mean * count is that of all samples of a member. It is rounded once for each member and once at the end.
    weight = counts.reshape(-1, *(1 for _ in values.shape[1:]))
    total = float(counts.sum())
    if statistic == "mean":
        return _sum(values * weight) / total
    return np.asarray(np.sqrt(_sum(values * values * weight) / total))


def _sum(terms: NDArray[Any]) -> NDArray[Any]:
    """Returns the sums over the first axis, correctly rounded."""
    if np.iscomplexobj(terms):
        return np.asarray(_sum(np.real(terms)) + 1j * _sum(np.imag(terms)))
    columns = terms.reshape(len(terms), -1).T
    sums = [math.fsum(column) if np.isfinite(column).all() else float(column.sum()) for column in columns.astype(float)]
    return np.array(sums).reshape(terms.shape[1:])
