"""One of every RPC with the Python client, for those who attack what is between it and the server: `CALLS`."""
import numpy as np

METHOD = {"name": "variational", "order": 4}
SCENE = {"system": "rigid_body", "step": 0.05, "method": METHOD,
         "body": {"moments": [1, 2, 3], "angular_velocity": [0.1, 1, 0.2]}}
WIDE = {"system": "stiefel", "step": 0.01, "inertia": list(np.linspace(1, 2, 40)), "method": {"name": "rk4"},
        "initial": {"Q": np.eye(20, 40), "S": np.hstack([np.zeros((20, 20)), np.eye(20)])}}


def drive(session):
    with session.drive(fields=["Q", "M"]) as loop:
        return [loop.step(to=k, fields="Q")["Q"] for k in range(0, 40, 3)]


def summarize(session):
    """Of 20 000 steps, so that it can break in between; with checkpoints, from which it goes on."""
    told = session.summarize(20_000, {"energy": ["last", "drift"], "Q": ["mean"]}, checkpoint_every=2000)
    return told["energy"]["last"], told["energy"]["drift"], told["Q"]["mean"]


def fork(client, session):
    with session.fork(at=5, id=session.id + ".fork") as other:
        return other.step(to=7, fields="Q")["Q"]


def session_call(work, scene=SCENE):
    def call(client, name):
        with client.create(scene, id=name) as session:
            return work(client, session)
    return call


# A function (client, id of a session) whose answer depends on nothing else.
CALLS = {
    "Describe": lambda client, name: client.describe().numerics_id,
    "CreateSession": session_call(lambda client, session: session.scene["method"]),
    "GetSession": session_call(lambda client, session: client.get(session.id).scene["body"]["moments"]),
    "ListSessions": session_call(lambda client, session: session.id in [one.id for one in client.list()]),
    "DeleteSession": lambda client, name: client.delete(name),
    "Step": session_call(lambda client, session: session.step(to=100, fields="Q")["Q"]),
    "Drive": session_call(lambda client, session: drive(session)),
    "Stream": session_call(lambda client, session: session.trajectory(to=400, fields=["Q", "M"])["Q"]),
    "Stream of large samples": session_call(
        lambda client, session: session.trajectory(to=40, every=2, fields=["Q"])["Q"], WIDE),
    "Diagnose": session_call(lambda client, session: [i.value for i in session.diagnose(to=50).invariants]),
    "ForkSession": session_call(fork),
    "Summarize": session_call(lambda client, session: summarize(session)),
    "Convert": lambda client, name: client.convert(SCENE, "velocity").blocks["Qdot"],
    "Connect": lambda client, name: client.geodesic([1, 2, 3], [[1, 0, 0]], [[0, 1, 0]], samples=5).trajectory,
    "MeasureTradeoff": lambda client, name: client.tradeoff(SCENE, horizon=0.5, budget=3e8, repeats=1).setup.horizon,
}
