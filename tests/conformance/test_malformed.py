"""Wrong requests are refused with their code, the path of the field and the rule, and change nothing."""
import grpc
import numpy as np
import pytest

import scenes
import stiefel
from stiefel import v1 as pb
from stiefel._wire.failures import from_status
from stiefel._scene import to_matrix

INVALID, MISSING, EXISTS = stiefel.InvalidArgument, stiefel.NotFound, stiefel.AlreadyExists
BIG = 2**53 + 1
NAN, INF = float("nan"), float("inf")
Q = np.eye(3)
SHEAR = np.array([[1, 1e-3, 0], [0, 1, 0], [0, 0, 1]])


def poked(matrix, i, j, value):
    matrix = np.array(matrix, dtype=float)
    matrix[i, j] = value
    return matrix


def message(scene):
    """Returns the message that a client without any checks would send."""
    out = pb.Scene(system=scene.get("system", ""), inertia=scene.get("inertia", []),
                          step=scene.get("step"), method=scene.get("method"), body=scene.get("body"),
                          epsilon=scene.get("epsilon"), parameter=scene.get("parameter"))
    for name, block in scene.get("initial", {}).items():
        if isinstance(block, pb.Matrix):
            out.initial[name].CopyFrom(block)
        else:
            block = np.atleast_2d(block)
            out.initial[name].CopyFrom(pb.Matrix(rows=block.shape[0], cols=block.shape[1], values=block.ravel()))
    return out


def create(id="malformed", checkpoint=b"", **changes):
    return "CreateSession", pb.CreateSessionRequest(session_id=id, checkpoint=checkpoint,
                                                    scene=message(scenes.rigid_body(**changes)))


def create_body(**changes):
    return "CreateSession", pb.CreateSessionRequest(session_id="malformed", scene=message(scenes.body(**changes)))


def blocks(Q=Q, M=scenes.M3, **more):
    return create(initial={"Q": Q, "M": M, **more})


def method(**changes):
    return create(method={"name": "variational", **changes})


def stream(**range_):
    return "Stream", pb.StreamRequest(session_id="good", **range_)


def diagnose(**asked):
    return "Diagnose", pb.DiagnoseRequest(session_id="good", **asked)


def fork(**changes):
    return "ForkSession", pb.ForkSessionRequest(**{"session_id": "malformed", "from_session_id": "good", **changes})


def convert(to="velocity", scene=None, **more):
    return "Convert", pb.ConvertRequest(scene=message(scenes.rigid_body(**scene or {})), to=to, **more)


def measure(scene=None, **more):
    return "MeasureTradeoff", pb.MeasureTradeoffRequest(scene=message(scenes.rigid_body(**scene or {})), **more)


def connect(number=2, q_t=np.eye(2, 3), q_0=np.eye(2, 3), inertia=(1, 2, 3), time=1, **more):
    good = pb.FramePair(q_0=to_matrix(q_0, "Q"), q_t=to_matrix(np.eye(2, 3), "Q"))
    last = pb.FramePair(q_0=good.q_0, q_t=q_t if q_t is None or isinstance(q_t, pb.Matrix) else to_matrix(q_t, "Q"))
    return "Connect", pb.ConnectRequest(pairs=[good] * (number - 1) + [last] * (number > 0), inertia=inertia, time=time, **more)


# (request, exception, field path, words of the rule)
MALFORMED = {
    # names
    "no system": (create(system=None), INVALID, "scene.system", "must be one of"),
    "unknown system": (create(system="rigid_boddy"), INVALID, "scene.system",
                       "rigid_boddy.*must be one of.*; did you mean rigid_body\\?"),
    "unknown method": (create(method={"name": "euler"}), INVALID, "scene.method.name", "euler.*must be one of"),
    "method of a discrete system": (create(system="moser_veselov"), INVALID, "scene.method", "takes no method"),
    "unknown order": (method(order=3), INVALID, "scene.method.order", "3.*must be one of"),
    "order of a method of one order": (create(method={"name": "rk4", "order": 2}), INVALID, "scene.method.order",
                                       "one of 4"),
    "order of an exact method": (create(method={"name": "exact", "order": 4}), INVALID, "scene.method.order",
                                 "must be absent"),
    "method of three dimensions": (create(method={"name": "exact"}, inertia=[1, 2, 3, 4], initial={"M": np.zeros((4, 4))}),
                                   INVALID, "scene.method.name",
                                   "exact.*N = 4: is only for N = 3, or Lambda of at most two values"),
    "no substeps": (method(substeps=0), INVALID, "scene.method.substeps", "0.*must be 1"),
    "huge substeps": (method(substeps=2**32 - 1), INVALID, "scene.method.substeps", "4294967295"),
    "unknown arithmetic": (method(arithmetic="exact"), INVALID, "scene.method.arithmetic", "compensated or plain"),
    # the step
    "no scene": (("CreateSession", pb.CreateSessionRequest(session_id="malformed")), INVALID, "scene", "absent"),
    "epsilon of a system without": (create(epsilon=1.0), INVALID, "scene.epsilon", "given: must be absent"),
    "parameter of a system without": (create(parameter=1.0), INVALID, "scene.parameter", "given: must be absent"),
    "an order that no integer holds": (method(order=2**31), INVALID, "scene.method.order", "2147483648: is too large"),
    "a method near": (create(method={"name": "munte_kaas4"}), INVALID, "scene.method.name", "did you mean munthe_kaas4"),
    "no step of the symmetric map": (create(system="symmetric_moser_veselov", method=None, step=None), INVALID, "scene.step",
                                     "absent: must be given, finite and not 0"),
    "no step": (create(step=None), INVALID, "scene.step", "absent: must be given, finite and not 0"),
    "zero step": (create(step=0.0), INVALID, "scene.step", "step: 0: must be finite and not 0"),
    "NaN step": (create(step=NAN), INVALID, "scene.step", "nan.*finite"),
    "infinite step": (create(step=-INF), INVALID, "scene.step", "inf.*finite"),
    # inertia
    "no inertia": (create(inertia=None), INVALID, "scene.inertia", "absent: must have 2 to"),
    "neither body nor inertia": (create(inertia=None, initial=None), INVALID, "scene.body", "absent: must be given, or inertia and initial"),
    "inertia of one": (create(inertia=[1]), INVALID, "scene.inertia", "must have 2 to"),
    "too large a dimension": (create(inertia=np.ones(5000)), INVALID, "scene.inertia", "5000 numbers"),
    "NaN inertia": (create(inertia=[1, NAN, 2]), INVALID, "scene.inertia[1]", "finite"),
    "a sum that is zero": (create(inertia=[1, -1, 2]), INVALID, "scene.inertia", "= 0.*must be > 0"),
    "a sum that is negative": (create(inertia=[-2, 1, 3]), INVALID, "scene.inertia", "= -1.*must be > 0"),
    "inertia of another size": (create(inertia=[1, 2, 3, 4]), INVALID, "scene.initial.M", "must be 4 x 4"),
    # blocks
    "no momentum": (create(initial={"Q": Q}), INVALID, "scene.initial.M", "absent"),
    "unknown block": (blocks(P=Q), INVALID, "scene.initial.P", "blocks of rigid_body are Q, M"),
    "Q of another shape": (blocks(Q=np.eye(4)), INVALID, "scene.initial.Q", "4 x 4.*must be 3 x 3"),
    "M that is a vector": (blocks(M=[[1, 2, 3]]), INVALID, "scene.initial.M", "1 x 3.*must be 3 x 3"),
    "too few values": (blocks(Q=pb.Matrix(rows=3, cols=3, values=[1, 0, 0])), INVALID, "scene.initial.Q.values",
                       "3 values.*= 9"),
    "a shape of 10^9 elements": (blocks(Q=pb.Matrix(rows=31623, cols=31623, values=[1])), INVALID,
                                 "scene.initial.Q", "31623 x 31623.*at most"),
    "a shape that overflows": (blocks(M=pb.Matrix(rows=2**32 - 1, cols=2**32 - 1)), INVALID,
                               "scene.initial.M.cols", "4294967295"),
    "an empty block": (blocks(M=pb.Matrix()), INVALID, "scene.initial.M.rows", "0.*must be 1 to"),
    "NaN in Q": (blocks(Q=poked(Q, 1, 2, NAN)), INVALID, "scene.initial.Q[1,2]", "nan.*finite"),
    "infinity in M": (blocks(M=poked(scenes.M3, 0, 1, INF)), INVALID, "scene.initial.M[0,1]", "inf.*finite"),
    "Q that is not orthogonal": (blocks(Q=SHEAR), INVALID, "scene.initial.Q", "0.001.*orthonormal"),
    "Q that is zero": (blocks(Q=np.zeros((3, 3))), INVALID, "scene.initial.Q", "orthonormal"),
    "M that is not skew": (blocks(M=poked(scenes.M3, 0, 1, 1)), INVALID, "scene.initial.M", "skew"),
    "M with a diagonal": (blocks(M=poked(scenes.M3, 0, 0, 1e-3)), INVALID, "scene.initial.M", "skew"),
    # bodies
    "a body and inertia": (create(body={"moments": [1, 2, 3], "angular_velocity": [1, 0, 0]}), INVALID, "scene.inertia",
                           "absent when `body`"),
    "no moments": (create_body(moments=None), INVALID, "scene.body", "exactly one"),
    "moments and tensor": (create_body(inertia_tensor=[1, 2, 3, 0, 0, 0]), INVALID, "scene.body", "exactly one"),
    "two moments": (create_body(moments=[1, 2]), INVALID, "scene.body.moments", "3 numbers"),
    "a tensor of nine": (create_body(moments=None, inertia_tensor=range(9)), INVALID, "scene.body.inertia_tensor",
                         "6 numbers"),
    "an indefinite tensor": (create_body(moments=None, inertia_tensor=[1, 1, 1, 2, 0, 0]), INVALID,
                             "scene.body.inertia_tensor", "moment.*> 0"),
    "a negative moment": (create_body(moments=[1, 2, -3]), INVALID, "scene.body.moments", "-3.*> 0"),
    "NaN moment": (create_body(moments=[1, NAN, 3]), INVALID, "scene.body.moments[1]", "finite"),
    "no angular velocity": (create_body(angular_velocity=None), INVALID, "scene.body.angular_velocity", "angular_velocity: absent: must have 3 numbers"),
    "infinite angular velocity": (create_body(angular_velocity=[0, INF, 0]), INVALID, "scene.body.angular_velocity[1]",
                                  "finite"),
    "a quaternion of three": (create_body(attitude=[1, 0, 0]), INVALID, "scene.body.attitude", "4 numbers"),
    "a quaternion that is not a unit": (create_body(attitude=[1, 1, 0, 0]), INVALID, "scene.body.attitude",
                                        "of norm 1.4142135623730951: must have norm 1"),
    # sessions
    "no id": (create(id=""), INVALID, "session_id", "1 to 128"),
    "a long id": (create(id="x" * 129), INVALID, "session_id", "1 to 128"),
    "an id with a slash": (create(id="a/b"), INVALID, "session_id", "A-Z"),
    "garbage for a checkpoint": (create(checkpoint=b"garbage"), INVALID, "checkpoint", "checkpoint"),
    "the same id, another scene": (create(id="good", step=0.5), EXISTS, None, "good.*another scene"),
    "get of an unknown session": (("GetSession", pb.GetSessionRequest(session_id="nobody")), MISSING, None, "nobody"),
    "step of an unknown session": (("Step", pb.StepRequest(session_id="nobody", to=1)), MISSING, None, "nobody"),
    "diagnosis of an unknown session": (("Diagnose", pb.DiagnoseRequest(session_id="nobody")), MISSING, None, "nobody"),
    "stream of an unknown session": (("Stream", pb.StreamRequest(session_id="nobody", to=1)), MISSING, None, "nobody"),
    # steps, ranges, fields
    "step to a negative step": (("Step", pb.StepRequest(session_id="good", to=-1)), INVALID, "to", "-1.*must be 0"),
    "a step that no double holds": (("Step", pb.StepRequest(session_id="good", to=BIG)), INVALID, "to", str(BIG)),
    "diagnosis of a negative step": (("Diagnose", pb.DiagnoseRequest(session_id="good", to=-7)), INVALID, "to", "-7"),
    "an unknown field": (("Step", pb.StepRequest(session_id="good", fields=["Q", "X"])), INVALID, "fields[1]", "X"),
    "a field twice": (("Step", pb.StepRequest(session_id="good", fields=["Q", "Q"])), INVALID, "fields[1]", "Q"),
    "an unknown invariant": (("Diagnose", pb.DiagnoseRequest(session_id="good", invariants=["entropy"])), INVALID,
                             "invariants[0]", "entropy"),
    "a backwards range": (stream(**{"from": 10, "to": 5}), INVALID, "to", "5: must be 10 to"),
    "a range from before 0": (stream(**{"from": -1, "to": 5}), INVALID, "from", "-1"),
    "a negative every": (stream(to=5, every=-1), INVALID, "every", "-1"),
    "a stream of an unknown field": (stream(to=5, fields=["nope"]), INVALID, "fields[0]", "nope"),
    "an unknown wish": (diagnose(estimate_error=7), INVALID, "estimate_error", "7"),
    "too many forms": (diagnose(forms=[{}] * 10_001), INVALID, "forms", "10001: must be at most 10000"),
    "too many pairs of a test": (diagnose(symplectic_test={"pairs": 1001}), INVALID, "symplectic_test.pairs", "1001"),
    "a bracket of another system": (diagnose(dirac_brackets=[{}]), INVALID, "dirac_brackets[0]", "rigid_body"),
    "a form near": (diagnose(forms=[{"form": "omgea"}]), INVALID, "forms[0].form", "did you mean omega"),
    "a field near": (("Step", pb.StepRequest(session_id="good", fields=["Omga"])), INVALID, "fields[0]", "did you mean Omega"),
    # forks
    "a fork of no id": (fork(from_session_id="a b"), INVALID, "from_session_id", "a b"),
    "a fork from before 0": (fork(from_step=-1), INVALID, "from_step", "-1"),
    "a fork with a step of 0": (fork(step=0), INVALID, "step", "0"),
    "a fork with a method near": (fork(method={"name": "rk5"}), INVALID, "method.name", "did you mean rk4"),
    "a fork with a huge order": (fork(method={"name": "rk4", "order": 2**31}), INVALID, "method.order", "too large"),
    "a fork to a system near": (fork(system="stifel"), INVALID, "system", "did you mean stiefel"),
    "a fork to a system out of reach": (fork(system="double_bracket"), INVALID, "system", "cannot be reached"),
    # conversions
    "a conversion of no scene": (("Convert", pb.ConvertRequest(to="velocity")), INVALID, "scene", "absent"),
    "a conversion of a wrong scene": (convert(scene={"inertia": [1, NAN, 2]}), INVALID, "scene.inertia[1]", "finite"),
    "a conversion to what is near": (convert("velocitty"), INVALID, "to", "did you mean velocity"),
    "a parameter that is no number": (convert("parametric_rigid_body", parameter=NAN), INVALID, "parameter",
                                      "nan: must be finite"),
    "an epsilon of 0": (convert("symmetric_rigid_body", epsilon=0), INVALID, "epsilon", "0: must be finite and not 0"),
    # trade-offs
    "a trade-off of no scene": (("MeasureTradeoff", pb.MeasureTradeoffRequest()), INVALID, "scene", "absent"),
    "a trade-off of a wrong scene": (measure({"inertia": [1, NAN, 2]}), INVALID, "scene.inertia[1]", "finite"),
    "a trade-off repeated too often": (measure(repeats=4_000_000_000), INVALID, "repeats", "4000000000: must be 1 to 100"),
    # geodesics
    "no pairs": (connect(0), INVALID, "pairs", "0 pairs: must be 1 to 1024"),
    "too many pairs": (connect(1025), INVALID, "pairs", "1025 pairs"),
    "no last frame": (connect(q_t=None), INVALID, "pairs[1].Q_T", "absent"),
    "a frame of too many values": (connect(q_t=pb.Matrix(rows=2, cols=3, values=range(7))), INVALID, "pairs[1].Q_T.values",
                                   "7 values"),
    "a frame of no rows": (connect(q_t=pb.Matrix(cols=3, values=[1])), INVALID, "pairs[1].Q_T.rows", "0"),
    "frames of two shapes": (connect(q_t=np.eye(3)), INVALID, "pairs[1].Q_T", "3 x 3: must have the shape of Q_0, 2 x 3"),
    "a frame that is not orthonormal": (connect(q_t=[[1, 3e-6, 0], [0, 1, 0]]), INVALID, "pairs[1].Q_T",
                                        "3e-06: must have orthonormal rows to 1e-06"),
    "NaN in a frame": (connect(q_t=[[1, NAN, 0], [0, 1, 0]]), INVALID, "pairs[1].Q_T", "must be finite"),
    "frames of one number": (connect(1, q_t=np.ones((1, 1)), q_0=np.ones((1, 1)), inertia=[1]), INVALID, "pairs[0].Q_0", ""),
    "a sum of lambda that is negative": (connect(1, q_t=np.eye(3), q_0=np.eye(3), inertia=[1, 2, -1]), INVALID, "inertia", ""),
    "NaN lambda": (connect(inertia=[1, NAN, 3]), INVALID, "inertia[1]", "nan"),
    "a lambda too many": (connect(inertia=[1, 2, 3, 1]), INVALID, "inertia", "4 numbers: must have 3"),
    "a negative time": (connect(time=-1e-9), INVALID, "time", "-1e-09"),
    "too many steps": (connect(steps=2**31), INVALID, "steps", "2147483648"),
    "too many samples": (connect(samples=2**31), INVALID, "samples", "2147483648"),
    "too many restarts": (connect(restarts=2**31), INVALID, "restarts", "2147483648"),
    "lambda of the Euclidean metric": (connect(metric=pb.METRIC_EUCLIDEAN), INVALID, "inertia",
                                       "3 numbers: must be absent with METRIC_EUCLIDEAN"),
    "no metric": (connect(metric=9), INVALID, "metric", "9"),
    "a page after no page": (("ListSessions", pb.ListSessionsRequest(page_token="a/b")), INVALID, "page_token", "a/b: must have 1 to 128"),
}


SUMMARIES = [
    (dict(quantities=[pb.Quantity(name="enrgy", statistics=[1])]), "quantities[0].name"),
    (dict(quantities=[pb.Quantity(name="energy", statistics=[99])]), "quantities[0].statistics"),
    (dict(quantities=[pb.Quantity(name="energy")]), "quantities[0].statistics"),
    (dict(quantities=[pb.Quantity(name="energy", statistics=[1])] * 65), "quantities"),
    (dict(quantities=[pb.Quantity(name="M", quantiles=[0.5])], to=2**20), "quantities"),
    (dict(quantities=[pb.Quantity(name="M", edges=[2, 1])]), "quantities[0].edges"),
    (dict(quantities=[pb.Quantity(name="energy", statistics=[1])] * 2), "quantities[1].name"),
    (dict(quantities=[pb.Quantity(name="M", quantiles=[1.5])]), "quantities[0].quantiles"),
    (dict(quantities=[pb.Quantity(name="M", edges=[1])]), "quantities[0].edges"),
    (dict(quantities=[pb.Quantity(name="M", statistics=[1], over_members=True)]), "quantities[0].over_members"),
    (dict(events=[pb.Event(field="energy", coefficients=[1])]), "events[0].field"),
    (dict(events=[pb.Event(field="M", coefficients=[1])]), "events[0].coefficients"),
    (dict(events=[pb.Event(field="M", coefficients=[0] * 9)]), "events[0].coefficients"),
    (dict(events=[pb.Event(field="M", coefficients=[1] * 9, level=INF)]), "events[0]"),
    (dict(events=[pb.Event(field="M", coefficients=[1] * 9)] * 65), "events"),
    (dict(events=[pb.Event(field="M", coefficients=[1] * 9, plus=[pb.LinearTerm(field="energy", coefficients=[1])])]), "events[0].plus[0].field"),
    (dict(events=[pb.Event(field="M", coefficients=[1] * 9, plus=[pb.LinearTerm(field="Q", coefficients=[1])])]), "events[0].plus[0].coefficients"),
    (dict(events=[pb.Event(field="M", coefficients=[1] * 9, plus=[pb.LinearTerm(field="Q", coefficients=[NAN] * 9)])]), "events[0].plus[0]"),
    (dict(events=[pb.Event(field="M", coefficients=[float("nan")] * 9)]), "events[0]"),
    (dict(events=[pb.Event(field="M", coefficients=[1] * 9, direction=7)]), "events[0].direction"),
    (dict(events=[pb.Event(field="M", coefficients=[1] * 9, plus=[pb.LinearTerm(field="M", coefficients=[0] * 9)] * 65)]), "events[0].plus"),
    (dict(times=[0.5, 0.2]), "times[1]"),
    (dict(times=[INF]), "times[0]"),
    (dict(times=[-1.0]), "times[0]"),
    (dict(times=[6.0]), "times[0]"),
    (dict(fields=["nothing"]), "fields[0]"),
    (dict(fields=["Q", "Q"]), "fields[1]"),
    (dict(to=-1), "to"),
    (dict(every=-1), "every"),
    (dict(checkpoint_every=-1), "checkpoint_every"),
    (dict(checkpoint=b"x"), "checkpoint"),
]
MALFORMED |= {f"a summary whose {field} is wrong, {k}": (("Summarize", pb.SummarizeRequest(session_id="good", **{"to": 100, **change})), INVALID, field, "")
              for k, (change, field) in enumerate(SUMMARIES)}


@pytest.fixture(scope="module", autouse=True)
def good(client):
    with client.create(scenes.rigid_body(), id="good") as session:
        yield session


def ask(client, method, request):
    if method in ("Stream", "MeasureTradeoff", "Connect", "Summarize"):
        try:
            return list(getattr(client._stub, method)(request))
        except grpc.RpcError as failure:
            raise client._connection.error(failure) from None
    return client._connection.call(method, request)


@pytest.mark.parametrize("name", MALFORMED)
def test_code_field_and_rule(client, good, name):
    (method, request), exception, field, words = MALFORMED[name]
    before = client.get("good")._message.cursor
    with pytest.raises(exception, match=words) as caught:
        ask(client, method, request)
    error = caught.value
    if field is None:
        assert error.reason and error.metadata["session_id"] == request.session_id
    else:
        assert field in [violation.field for violation in error.violations]
        rule = next(violation.description for violation in error.violations if violation.field == field)
        assert rule and rule in error.message
    if method == "CreateSession" and exception is INVALID:
        with pytest.raises((MISSING, INVALID)):
            client.get(request.session_id)
    assert client.get("good")._message.cursor == before
    assert good.step(to=before).step == before


def test_every_violation_is_told_at_once(client):
    scene = message(scenes.rigid_body(step=0.0, inertia=[1, -1, 2], initial={"Q": SHEAR, "M": scenes.M3}))
    with pytest.raises(INVALID) as caught:
        client.create(scene)
    fields = {violation.field for violation in caught.value.violations}
    assert fields == {"scene.step", "scene.inertia", "scene.initial.Q"}


def test_a_bad_request_does_not_end_a_drive(good):
    with good.drive() as drive:
        assert drive.step(5).step == 5
        with pytest.raises(INVALID) as caught:
            drive.step(-3)
        assert caught.value.violations[0].field == "to"
        with pytest.raises(INVALID) as caught:
            drive.step(6, fields=["nope"])
        assert caught.value.violations[0].field == "fields[0]"
        assert drive.step(6, fields=["M"]).fields.keys() == {"M"}
        assert drive.step(7).fields.keys() == {"M"}, "the last fields that were named hold on"


def test_a_drive_of_an_unknown_session(client):
    reply = next(client._stub.Drive(iter([pb.DriveRequest(session_id="nobody", to=1)])))
    assert isinstance(from_status(reply.error), MISSING) and "nobody" in reply.error.message
