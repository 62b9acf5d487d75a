"""A server that fails on purpose, and otherwise knows one session whose field x is its step."""
import threading
from concurrent.futures import ThreadPoolExecutor

import grpc
import numpy as np

from stiefel.v1 import error_pb2, outcome_pb2, scene_pb2, simulation_pb2 as pb
from stiefel.v1.simulation_pb2_grpc import SimulationServiceServicer, add_SimulationServiceServicer_to_server

REACHED = outcome_pb2.RunStatus(outcome=outcome_pb2.OUTCOME_REACHED)

SESSION = pb.Session(session_id="fake", scene=scene_pb2.Scene(system="rigid_body", step=0.5))


def field(steps):
    data = np.array(steps, dtype="<f8").tobytes()
    tensor = scene_pb2.Tensor(shape=[len(steps), 1, 1], data_type=scene_pb2.DATA_TYPE_FLOAT64, data=data)
    return pb.Field(name="x", value=tensor)


class Fake(SimulationServiceServicer):
    """`failures` is how the next calls fail, first come first served; a number breaks a stream after
    so many messages. A stream computes what it tells of, and waits `pause` seconds before each message."""

    pause = 0.0

    def __init__(self):
        self.failures = []
        self.requests = []

    def _receive(self, request, context):
        self.requests.append(request)
        if self.failures and not isinstance(self.failures[0], int):
            context.abort(self.failures.pop(0), "on purpose")

    def GetSession(self, request, context):
        self._receive(request, context)
        return pb.GetSessionResponse(session=SESSION)

    def Describe(self, request, context):
        self._receive(request, context)
        bad = error_pb2.BadRequest(field_violations=[
            error_pb2.BadRequest.FieldViolation(field="initial.Q", description="1: must be 2")])
        status = error_pb2.Status(code=3, message="told")
        status.details.add(type_url="type.googleapis.com/google.rpc.BadRequest", value=bad.SerializeToString())
        status.details.add(type_url="type.googleapis.com/google.rpc.ErrorInfo", value=error_pb2.ErrorInfo(
            reason="BECAUSE", domain="stiefel", metadata={"a": "b"}).SerializeToString())
        context.set_trailing_metadata((("grpc-status-details-bin", status.SerializeToString()),))
        context.abort(grpc.StatusCode.INVALID_ARGUMENT, "told")

    def Step(self, request, context):
        self._receive(request, context)
        return pb.StepResponse(run_status=REACHED, sample=pb.Sample(step=request.to))

    def Drive(self, requests, context):
        for request in requests:
            self._receive(request, context)
            yield pb.DriveResponse(step=self.Step(request, context))

    def Stream(self, request, context):
        self._receive(request, context)
        breaks = self.failures.pop(0) if self.failures else None
        start, every = getattr(request, "from"), request.every
        steps = list(range(start, request.to, every)) + [request.to]
        for count, begin in enumerate(range(0, len(steps), 10)):
            if count == breaks:
                context.abort(grpc.StatusCode.UNAVAILABLE, "on purpose")
            part = steps[begin:begin + 10]
            threading.Event().wait(self.pause)  # which nobody patches
            yield pb.StreamResponse(steps=part, times=[step * 0.5 for step in part], fields=[field(part)],
                                    computed_steps=part[-1] - start)
        if breaks == -1:
            context.abort(grpc.StatusCode.UNAVAILABLE, "on purpose")
        yield pb.StreamResponse(run_status=REACHED, computed_steps=request.to - start)


def serve(folder):
    """The fake, its server and its address."""
    fake, server, address = Fake(), grpc.server(ThreadPoolExecutor(4)), f"unix:{folder}/fake"
    add_SimulationServiceServicer_to_server(fake, server)
    server.add_insecure_port(address)
    server.start()
    return fake, server, address
