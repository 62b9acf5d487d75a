"""The calls of every_call.txtpb with the Python client, for those who attack what is between it and the server: `CALLS`.
Those of many steps have more of them than in the list, so that they can break in between."""
import numpy as np

import stiefel
from calls_proto import field_of
from every_call import every_call

REQUESTS = {rpc: requests for rpc, requests in every_call()}
SCENE = stiefel.to_dict(REQUESTS["CreateSession"][0].scene)
WIDE = {"system": "stiefel", "step": 0.01, "inertia": list(np.linspace(1, 2, 40)), "method": {"name": "rk4"},
        "initial": {"Q": np.eye(20, 40), "S": np.hstack([np.zeros((20, 20)), np.eye(20)])}}


def drive(session, first):
    with session.drive(fields=list(first.fields)) as loop:
        return [loop.step(to=k, fields="Q")["Q"] for k in range(0, 40, first.to)]


def summarize(session):
    """With checkpoints, from which it goes on."""
    told = session.summarize(20_000, quantities={"energy": ["last", "drift"], "Q": ["mean"]}, checkpoint_every=2000)
    return told["energy"]["last"], told["energy"]["drift"], told["Q"]["mean"]


def fork(session, request):
    with session.fork(at=request.from_step, id=session.id + ".fork", method={"name": request.method.name}) as other:
        return other.step(to=7, fields="Q")["Q"]


def connect(client, request):
    pair = request.pairs[0]
    Q_0, Q_T = ([list(frame.values)] for frame in (pair.q_0, pair.q_t))
    return client.geodesics([(Q_0, Q_T)], inertia=list(request.inertia), time=request.time, samples=request.samples)[0].trajectory


OF_SESSIONS = {  # functions (client, session, request)
    "CreateSession": lambda client, session, request: session.scene["method"],
    "GetSession": lambda client, session, request: client.get(session.id).scene["body"]["moments"],
    "ListSessions": lambda client, session, request: session.id in [one.id for one in client.list()],
    "Step": lambda client, session, request: session.step(to=request.to, fields="Q")["Q"],
    "Drive": lambda client, session, request: drive(session, request),
    "Stream": lambda client, session, request: session.trajectory(to=10 * request.to, fields=["Q", "M"])["Q"],
    "Diagnose": lambda client, session, request: [i.value for i in session.diagnose(to=request.to).invariants],
    "ForkSession": lambda client, session, request: fork(session, request),
    "Summarize": lambda client, session, request: summarize(session),
    "LyapunovSpectrum": lambda client, session, request: session.lyapunov(to=10 * request.to, interval=1).exponents,
    "Linearize": lambda client, session, request: session.linearize(to=10 * request.to, inertia=True).matrix,
}
OTHERS = {  # functions (client, id of a session, request)
    "Describe": lambda client, name, request: client.describe().numerics_id,
    "DeleteSession": lambda client, name, request: client.delete(name),
    "Convert": lambda client, name, request: client.convert(request.scene, system=request.to).blocks["Qdot"],
    "Connect": lambda client, name, request: connect(client, request),
    "ConjugatePoints": lambda client, name, request: [point.time for point in client.conjugate_points(
        inertia=list(request.inertia), Q=[list(request.q.values)], Qdot=[list(request.qdot.values)], time=request.time)],
    "MeasureTradeoff": lambda client, name, request: client.tradeoff(
        request.scene, horizon=10 * request.horizon, budget=10 * request.budget, repeats=request.repeats).horizon,
}


def of_session(work, request, scene=SCENE):
    def call(client, name):
        with client.create(scene, id=name) as session:
            return work(client, session, request)
    return call


def of_client(work, request):
    return lambda client, name: work(client, name, request)


def by_name(client, session, rpc, request):
    """Calls the method with the name of the RPC, of the session that the request names or of the client, with the request's
    fields as arguments."""
    given = {{"from": "start"}.get(field.name, field.name): value for field, value in request.ListFields() if field.name != "session_id"}
    return getattr(session if request.session_id else client, field_of(rpc))(**given)


def call_of(rpc, request):
    """By hand where the method has another name or other arguments."""
    if rpc in OTHERS:
        return of_client(OTHERS[rpc], request)
    return of_session(OF_SESSIONS.get(rpc, lambda client, session, request: by_name(client, session, rpc, request)), request)


# A function (client, id of a session) whose answer depends on nothing else.
CALLS = {rpc: call_of(rpc, requests[0]) for rpc, requests in REQUESTS.items()}
CALLS["Stream of large samples"] = of_session(
    lambda client, session, request: session.trajectory(to=request.to, every=request.every, fields=["Q"])["Q"],
    REQUESTS["Stream"][0], WIDE)
