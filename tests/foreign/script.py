"""The calls of every_call.txtpb and more, as JSON that any client of gRPC can send: `script(N)`."""
from __future__ import annotations

import base64
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Optional

import numpy as np
from google.protobuf import json_format

sys.path.insert(0, str(Path(__file__).parents[1] / "calls"))
from every_call import every_call  # noqa: E402

SIZES = (3, 64, 512)
STEPS = {3: 40, 64: 8, 512: 2}
Json = dict[str, Any]


@dataclass(frozen=True)
class Call:
    name: str
    rpc: str
    requests: tuple[Json, ...]  # several for Drive only
    fails: Optional[tuple[str, str]] = None  # status code and ErrorInfo.reason
    session: str = ""  # of the metadata stiefel-session


def tensor(array: np.ndarray) -> Json:
    return {"shape": list(array.shape), "data_type": "DATA_TYPE_FLOAT64",
            "data": base64.b64encode(array.astype("<f8").tobytes()).decode()}


def scene(size: int) -> Json:
    """A rigid body in so many dimensions."""
    if size == 3:
        return {"system": "rigid_body", "step": 0.05, "method": {"name": "variational", "order": 4},
                "body": {"moments": [1, 2, 3], "angular_velocity": [0.1, 1, 0.2]}}
    random = np.random.default_rng(size)
    orthogonal, _ = np.linalg.qr(random.standard_normal((size, size)))
    upper = np.triu(random.standard_normal((size, size)), 1)
    return {"system": "rigid_body", "step": 0.01, "method": {"name": "rk4"}, "inertia": list(np.linspace(1, 2, size)),
            "initial_tensors": {"Q": tensor(orthogonal), "M": tensor((upper - upper.T) / size)}}


def scene_of_arrays(size: int) -> Json:
    """`scene` as the Python client takes it."""
    described = scene(size)
    for name, each in described.pop("initial_tensors", {}).items():
        array = np.frombuffer(base64.b64decode(each["data"])).reshape(each["shape"])
        described.setdefault("initial", {})[name] = array
    return described


def frames(size: int) -> Json:
    """Two unit vectors a quarter of a great circle apart."""
    rows = [{"rows": 1, "cols": size, "values": list(np.eye(size)[k])} for k in (0, 1)]
    return {"q_0": rows[0], "q_t": rows[1]}


QUARTER = 0.5 * (np.pi / 2) ** 2  # the energy of the way between `frames` in time 1


def script(size: int) -> list[Call]:
    """The calls of every_call.txtpb with a scene of this size, and after some of them more calls of the same RPC. What does
    not fit into a message is refused, and comes by Stream."""
    body, id, fork, last = scene(size), f"s-{size}", f"f-{size}", STEPS[size]
    large = size == 512
    other = {  # than in the list: names, scenes, and steps that take a second at most
        "CreateSession": {"scene": body},
        "Step": {"to": last},
        "Stream": {"to": last},
        "Summarize": {"to": last, "times": [0, body["step"] / 3], "fields": ["Q"], "checkpoint_every": 0, "events": [],
                      "quantities": [{"name": "energy", "statistics": ["STATISTIC_LAST", "STATISTIC_DRIFT"]}]},
        "Diagnose": {"to": last},
        "Linearize": {"to": 2, "every": 1},
        "LyapunovSpectrum": {"to": 2 if large else 20, "every": 10, "interval": 1, "count": 2},
        "Convert": {"scene": body},
        "Connect": {"metric": "METRIC_EUCLIDEAN", "inertia": [], "pairs": [frames(size)], "samples": 4},
        "MeasureTradeoff": {"scene": body, "horizon": body["step"], "budget": 1e10},
    }
    fails = {"Step": ("INVALID_ARGUMENT", "REPLY_TOO_LARGE"),
             "LyapunovSpectrum": ("INVALID_ARGUMENT", ""),  # 20 intervals, the least, take minutes
             "MeasureTradeoff": ("INVALID_ARGUMENT", "")} if large else {}  # the reference takes 2e12 to the first state
    if size > 22:  # larger states have their vectors as blocks alone
        fails["Linearize"] = ("INVALID_ARGUMENT", "")

    def call(rpc: str, *requests: Json, name: str = "", fails: Optional[tuple[str, str]] = None) -> Call:
        session = requests[0].get("from_session_id") or requests[0].get("session_id", "")
        return Call(name or rpc, rpc, requests, fails, session)

    more = {
        "CreateSession": [
            call("CreateSession", {"session_id": id, "scene": body}, name="CreateSession again"),
            call("CreateSession", {"session_id": id, "scene": {**body, "step": 0.07}}, name="CreateSession of another scene",
                 fails=("ALREADY_EXISTS", "SESSION_HAS_OTHER_SCENE")),
            call("CreateSession", {"session_id": "bad", "scene": {**body, "step": 0}}, name="CreateSession without a step",
                 fails=("INVALID_ARGUMENT", ""))],
        "Step": [call("Step", {"session_id": id, "to": last, "fields": ["Q"]}, name="Step with Q")],
        "ForkSession": [call("Step", {"session_id": fork, "to": 1, "fields": ["Q"]}, name="Step of a fork")],
        "Convert": [call("Convert", {"scene": body, "to": "right_rigid_body", "view": "SCENE_VIEW_FULL"},
                         name="Convert to a system")],
    }
    calls = []
    for rpc, messages in every_call():
        requests = [json_format.MessageToDict(message, preserving_proto_field_name=True) for message in messages]
        if rpc == "Drive":  # the second of its requests is refused, and does not end the stream
            requests = [{"session_id": id, "to": 1, "fields": ["Q"]}, {"to": -1}, {"to": last}]
        for request in requests:
            request.update((key, int(value)) for key, value in request.items() if isinstance(value, str) and value.isdigit())
            request.update(other.get(rpc, {}))
            request.update({key: {"s": id, "f": fork}[request[key]] for key in ("session_id", "from_session_id")
                            if request.get(key) in ("s", "f")})
        calls += [call(rpc, *requests, fails=fails.get(rpc)), *more.pop(rpc, [])]
    return calls + [
        call("Step", {"session_id": id, "to": 1}, name="Step of a deleted session", fails=("NOT_FOUND", "SESSION_DELETED")),
        call("Step", {"session_id": "none", "to": 1}, name="Step of no session", fails=("NOT_FOUND", "SESSION_NOT_FOUND"))]
