"""The page of a run: the files of `page` in one, with the data of the run in it as JSON."""
from __future__ import annotations

import base64
import json
import math
import os
import re
from pathlib import Path
from typing import Any, Optional

import numpy as np

from stiefel import v1 as pb
from stiefel._given.numbers import refused
from stiefel._report import run_data
from stiefel._results import body, plots, sphere
from stiefel._results.base import Array
from stiefel._results.motion import Motion
from stiefel._results.save import complete, finite, in_json
from stiefel._wire import answers
from stiefel.errors import StiefelError

Session = Any  # a `stiefel.Session`
Trajectory = Any  # a `stiefel.Trajectory`

CHEAP = 5e9  #: instructions of a measurement that nobody asked for: about a second
LARGEST_SCENE = 600_000  #: characters; the page of a larger scene has not the arrays of its initial state
FILES = Path(__file__).with_name("page")


def write(path: "str | os.PathLike[str]", session: Session, to: int, name: Optional[str] = None, member: int = 0,
          estimate_error: bool = True, tradeoff: Optional[bool] = None) -> None:
    """Writes the page of the run of a session up to step `to`. The file appears under its name when it is complete."""
    text = html(data(session, to, name, member, estimate_error, tradeoff))
    with complete(path) as part:
        Path(part).write_text(text, encoding="utf-8")


def html(content: dict[str, Any]) -> str:
    """Returns the template with the data. No text in it can end the script that holds it."""
    block = json.dumps(finite(content), separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
    return template().replace("@DATA@", block, 1)


def template() -> str:
    """Returns page.html, in which each @FILE@ is replaced by that file: style and script in one page."""
    def text(name: str) -> str:
        return (FILES / name).read_text(encoding="utf-8")
    return re.sub(r"@(\w+\.\w+)@", lambda found: text(found[1]), text("page.html"))


def data(session: Session, to: int, name: Optional[str] = None, member: int = 0, estimate_error: bool = True,
         tradeoff: Optional[bool] = None) -> dict[str, Any]:
    """Returns what the page shows, as its script reads it."""
    if not 0 <= member < (session._resolved().members or 1):
        raise refused("member", f"{member}: is not a member of the scene")
    run = run_data.accuracy(session, to, estimate_error)
    drawn = run_data.samples(session, run)
    scene = session.scene
    of = member if scene.get("members") else None
    inertia = _inertia(drawn, of) if body.is_body(drawn) else None
    whole = len(json.dumps(scene)) <= LARGEST_SCENE
    title, curves = plots.rates(scene, drawn, of)
    return {
        "name": name or scene["system"], "file": f"{name or 'scene'}.json", "to": run.step, "member": of,
        "horizon": run.horizon, "turn": 2 * math.pi / run.speed if run.speed else None,
        "outcome": str(run.run_status.outcome), "message": run.run_status.message,
        "choice": session.choice.reason if session.choice else None,
        "epoch": session.epoch, "version": session._connection.call("Describe", pb.DescribeRequest()).version, "numerics_id": drawn.build, "side": drawn.origin.side,
        "scene": in_json(scene if whole else {key: value for key, value in scene.items() if not key.startswith("initial")}),
        "whole_scene": whole,
        "inertia": inertia, "character": _character(run.motion),
        "samples": {"time": _packed(drawn.time, np.float64),
                    **({} if drawn.utc is None else {"utc": _packed(drawn.utc.astype(float) / 1000, np.float64)}),  # milliseconds
                    "fields": {field: _field(body.matrices(values, of)) for field, values in drawn.fields.items()
                               if field in ("Q", "q") or inertia}},
        "rates": {"title": title if ":" in title else title.capitalize(), "curves": [
            {"name": name.replace("$", "").replace(r"\omega", "ω"), **_packed(values, np.float32)} for name, values in curves.items()]},
        "drift": {"time": run.time, "families": [vars(family) for family in run.families]},
        "error": {"time": run.error_time, **run.errors, "last": vars(run.error) if run.error else None},
        "tradeoff": _tradeoff(session, tradeoff, abs(run.horizon)),
    }


def _inertia(drawn: Trajectory, of: Optional[int]) -> dict[str, Any]:
    """Returns the principal axes, with the separatrix and the polhodes of other energies where no two moments are equal."""
    inertia = body.principal(drawn.scene, of)
    curves = {"separatrix": sphere.separatrix, "others": sphere.other_polhodes}
    return {"moments": inertia.moments.tolist(), "axes": inertia.axes.tolist(), "names": inertia.names, **{
        name: [curve[::3].round(4).tolist() for curve in (made(inertia.moments) if inertia.distinct else ())] for name, made in curves.items()}}


def _character(motion: Optional[Motion]) -> Optional[str]:
    """Returns what kind of motion it is, with the norm of the momentum and the energy."""
    if motion is None:
        return None
    units = (" kg m²/s", " J") if motion.in_si else ("", "")
    return f"{motion.kind.capitalize()}: |L| = {np.linalg.norm(motion.momentum):.5g}{units[0]}, energy {motion.energy:.5g}{units[1]}"


def _field(values: Array) -> dict[str, Any]:
    values = values[:, :run_data.LARGEST, :run_data.LARGEST]
    complex_ = np.iscomplexobj(values)
    numbers = np.stack([np.real(values), np.imag(values)], axis=-1) if complex_ else values
    return {"rows": values.shape[1], "cols": values.shape[2], "complex": complex_, **_packed(numbers, np.float32)}


def _packed(values: Array, dtype: Any) -> dict[str, str]:
    numbers = np.ascontiguousarray(values, dtype=np.dtype(dtype).newbyteorder("<"))
    return {"dtype": np.dtype(dtype).name, "data": base64.b64encode(numbers.tobytes()).decode()}


def _tradeoff(session: Session, asked: Optional[bool], horizon: float) -> Optional[dict[str, Any]]:
    """Measures error against cost at the end of the run, by default if that is cheap. Returns None where the scene has no trade-off, such as that
    of a discrete system, and where a measurement that was not asked for fails."""
    scene = session._resolved()
    if asked is False or (asked is None and (scene.HasField("members") or not scene.HasField("method"))):
        return None
    try:
        request = pb.MeasureTradeoffRequest(scene=scene, budget=None if asked else CHEAP, horizon=horizon or None)
        found = answers.tradeoff(session._connection.call_all("MeasureTradeoff", request))
    except StiefelError:
        if asked:
            raise
        return None
    return {"horizon": found.horizon, "reference_error": found.reference_error, "points": [
        {"method": point.method, "order": point.order, "work": point.work, "front": point in found.front,
         "error": point.error if point.success else None} for point in found.points]} if found.points else None
