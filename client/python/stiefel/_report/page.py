"""The page of a run: the template `page.html` with the data of one run in it as JSON."""
from __future__ import annotations

import base64
import json
import math
import os
from pathlib import Path
from typing import Any, Optional

import numpy as np

from stiefel._report import run as runs
from stiefel._results.base import Array

Session = Any  # a `stiefel.Session`

LARGEST_SCENE = 600_000  #: characters; the page of a larger scene has not the arrays of its initial state
TEMPLATE = Path(__file__).with_name("page.html")


def write(path: "str | os.PathLike[str]", session: Session, to: int, *, name: Optional[str] = None, member: int = 0,
          estimate_error: bool = True, tradeoff: Any = None) -> None:
    """Writes the page of the run of a session up to step `to`."""
    text = html(data(session, to, name, member, estimate_error, tradeoff))
    part = Path(os.fspath(path) + ".part")
    part.write_text(text, encoding="utf-8")
    os.replace(part, path)


def html(content: dict[str, Any]) -> str:
    """Returns the template with the data. No text in it can end the script that holds it."""
    block = json.dumps(_finite(content), separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
    return TEMPLATE.read_text(encoding="utf-8").replace("@DATA@", block, 1)


def data(session: Session, to: int, name: Optional[str] = None, member: int = 0, estimate_error: bool = True,
         tradeoff: Any = None) -> dict[str, Any]:
    """Returns what the page shows, as its script reads it."""
    run = runs.accuracy(session, to, estimate_error)
    drawn = runs.samples(session, run)
    scene = session.scene
    of = member if scene.get("members") else None
    whole = len(json.dumps(scene)) <= LARGEST_SCENE
    return {
        "name": name or scene["system"], "file": f"{name or 'scene'}.json", "to": run.step, "member": of,
        "horizon": run.horizon, "turn": 2 * math.pi / run.speed if run.speed else None,
        "outcome": str(run.run_status.outcome), "message": run.run_status.message,
        "choice": session.choice.reason if session.choice else None,
        "epoch": session.epoch, "version": runs.described(session).version, "numerics_id": session.message.numerics_id,
        "scene": scene if whole else {key: value for key, value in scene.items() if not key.startswith("initial")},
        "whole_scene": whole,
        "samples": {"time": _packed(drawn.time, np.float64),
                    "fields": {field: _field(runs.of_member(values, of)) for field, values in drawn.items()}},
        "drift": {"time": run.time, "families": [vars(family) for family in run.families]},
        "error": {"time": run.error_time, **run.errors, "last": vars(run.error) if run.error else None},
        "tradeoff": _tradeoff(tradeoff) if tradeoff else None,
    }


def _field(values: Array) -> dict[str, Any]:
    values = values[:, :runs.LARGEST, :runs.LARGEST]
    complex_ = np.iscomplexobj(values)
    numbers = np.stack([values.real, values.imag], axis=-1) if complex_ else values
    return {"rows": values.shape[1], "cols": values.shape[2], "complex": complex_, **_packed(numbers, np.float32)}


def _packed(values: Array, dtype: Any) -> dict[str, str]:
    numbers = np.ascontiguousarray(values, dtype=np.dtype(dtype).newbyteorder("<"))
    return {"dtype": np.dtype(dtype).name, "data": base64.b64encode(numbers.tobytes()).decode()}


def _tradeoff(found: Any) -> dict[str, Any]:
    return {"horizon": found.setup.horizon, "reference_error": found.setup.reference_error, "points": [
        {"method": point.method, "order": point.order, "work": point.work, "error": point.error, "front": point in found.front}
        for point in found.points]}


def _finite(value: Any) -> Any:
    """Returns the data with None for NaN and the infinities, which JSON does not have."""
    if isinstance(value, dict):
        return {key: _finite(one) for key, one in value.items()}
    if isinstance(value, (list, tuple)):
        return [_finite(one) for one in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
