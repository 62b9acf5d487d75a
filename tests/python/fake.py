"""A server that fails on purpose, and otherwise knows one session, whose field x is the step."""
from concurrent.futures import ThreadPoolExecutor

import grpc
import numpy as np

from stiefel import v1 as pb
from stiefel.v1.simulation_pb2_grpc import SimulationServiceServicer, add_SimulationServiceServicer_to_server

REACHED = pb.RunStatus(outcome=pb.OUTCOME_REACHED)

SESSION = pb.Session(session_id="fake", system="rigid_body", scene=pb.Scene(system="rigid_body", step=0.5),
                     numerics_id="of the fake")
SESSION.step_price.SetInParent()  # of no work, so that the client asks for no checkpoints


def tensor(array):
    return pb.Tensor(shape=array.shape, data_type=pb.DATA_TYPE_FLOAT64, data=array.astype("<f8").tobytes())


def field(steps):
    return pb.Field(name="x", value=tensor(np.array(steps, float).reshape(-1, 1, 1)))


def sample_at(step):
    """The state at a step, which is its field x."""
    return pb.Sample(step=step, time=0.5 * step, fields=[pb.Field(name="x", value=tensor(np.array([[float(step)]])))])


def refusal(delay=None):
    """RESOURCE_EXHAUSTED, to be tried again after `delay` seconds."""
    status = pb.Status(code=8, message="no place")
    if delay is not None:
        retry = pb.RetryInfo()
        retry.retry_delay.FromNanoseconds(round(1e9 * delay))
        status.details.add(type_url="type.googleapis.com/google.rpc.RetryInfo", value=retry.SerializeToString())
    return status


class Fake(SimulationServiceServicer):
    """`failures` is how the next calls fail, first come first served: with a code, or with a `refusal`; a number breaks
    a stream after so many messages. A stream computes what it tells of, and calls
    `before_message` before each message."""

    before_message = staticmethod(lambda: None)

    def __init__(self):
        self.failures = []
        self.requests = []

    def _receive(self, request, context):
        self.requests.append(request)
        if self.failures and isinstance(self.failures[0], pb.Status):
            status = self.failures.pop(0)
            context.set_trailing_metadata((("grpc-status-details-bin", status.SerializeToString()),))
            context.abort(grpc.StatusCode.RESOURCE_EXHAUSTED, status.message)
        if self.failures and not isinstance(self.failures[0], int):
            context.abort(self.failures.pop(0), "on purpose")

    def GetSession(self, request, context):
        self._receive(request, context)
        return pb.GetSessionResponse(session=SESSION)

    def DeleteSession(self, request, context):
        self._receive(request, context)
        return pb.DeleteSessionResponse()

    def Step(self, request, context):
        self._receive(request, context)
        return pb.StepResponse(run_status=REACHED, sample=sample_at(request.to),
                               checkpoint=b"checkpoint" if request.return_checkpoint else b"")

    def Drive(self, requests, context):
        for request in requests:
            if self.failures and isinstance(self.failures[0], pb.Status):
                self.requests.append(request)
                yield pb.DriveResponse(error=self.failures.pop(0))
                continue
            self._receive(request, context)
            yield pb.DriveResponse(step=self.Step(request, context))

    def Stream(self, request, context):
        self._receive(request, context)
        breaks = self.failures.pop(0) if self.failures else None
        messages = list(self._messages(request))
        for count, message in enumerate(messages):
            message.work = 1
            if count == breaks or (breaks == -1 and message is messages[-1]):
                context.abort(grpc.StatusCode.UNAVAILABLE, "on purpose")
            self.before_message()
            yield message

    def _messages(self, request):
        """Ten samples a message; the last has the run status alone."""
        start, every = getattr(request, "from"), request.every or 1
        steps = list(range(start, request.to, every)) + [request.to]
        for begin in range(0, len(steps), 10):
            some = steps[begin:begin + 10]
            yield pb.StreamResponse(steps=some, times=[step * 0.5 for step in some], fields=[field(some)],
                                    computed_steps=some[-1] - start)
        yield pb.StreamResponse(run_status=REACHED, computed_steps=request.to - start)


def serve(folder):
    """The fake, its server and its address."""
    fake, server, address = Fake(), grpc.server(ThreadPoolExecutor(4)), f"unix:{folder}/fake"
    add_SimulationServiceServicer_to_server(fake, server)
    server.add_insecure_port(address)
    server.start()
    return fake, server, address


class Breaks(grpc.RpcError):
    """A call of a stub whose stream breaks after so many messages, once for each number, and the error that it raises then."""

    def __init__(self, call, after):
        self.call, self.after, self.requests = call, list(after), []

    def __call__(self, request, timeout=None, metadata=None):
        self.requests.append(type(request).FromString(request.SerializeToString()))
        return self

    def __iter__(self):
        stream, left = self.call(self.requests[-1]), self.after.pop(0) if self.after else None
        for count, message in enumerate(stream):
            if count == left:
                stream.cancel()
                raise self
            yield message

    def code(self):
        return grpc.StatusCode.UNAVAILABLE

    def details(self):
        return "on purpose"

    def initial_metadata(self):
        return ()

    trailing_metadata = initial_metadata

    def cancel(self):
        pass
