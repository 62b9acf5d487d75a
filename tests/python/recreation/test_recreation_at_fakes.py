"""A handle creates its session again at servers that lose it over and over, or that have another build."""
import grpc
import numpy as np
import pytest

import fake
import stiefel
from stiefel import v1 as pb
from stiefel._wire import recreating
from stiefel._wire.connection import Connection


class Forgetful(fake.Fake):
    """The fake, which has lost its session when a call for it comes, `losses` times; `order` is what happened."""

    def __init__(self):
        super().__init__()
        self.losses, self.there, self.order = 0, True, []

    def CreateSession(self, request, context):
        self.order.append("create")
        self.there = True
        return pb.CreateSessionResponse(session=fake.SESSION)

    def error(self):
        """NOT_FOUND where the session is not there."""
        self.order.append("call")
        if self.losses > 0:
            self.there, self.losses = False, self.losses - 1
        if self.there:
            return None
        info = pb.ErrorInfo(reason="SESSION_NOT_FOUND", domain="stiefel", metadata={"session_id": "fake"})
        status = pb.Status(code=5, message="there is no such session")
        status.details.add(type_url="type.googleapis.com/google.rpc.ErrorInfo", value=info.SerializeToString())
        return status

    def Drive(self, requests, context):
        for request in requests:
            error = self.error()
            yield pb.DriveResponse(error=error) if error else pb.DriveResponse(step=super().Step(request, context))

    def _check(self, context):
        if error := self.error():
            context.set_trailing_metadata((("grpc-status-details-bin", error.SerializeToString()),))
            context.abort(grpc.StatusCode.NOT_FOUND, error.message)

    def Step(self, request, context):
        self._check(context)
        return super().Step(request, context)

    def Stream(self, request, context):
        self._check(context)
        yield from super().Stream(request, context)


@pytest.fixture
def forgetful(tmp_path, monkeypatch):
    monkeypatch.setattr(fake, "Fake", Forgetful)
    service, server, service.address = fake.serve(tmp_path)
    monkeypatch.setattr(Connection, "rest", lambda connection, seconds: service.order.append(seconds))
    yield service
    server.stop(None)


@pytest.mark.parametrize("losses", [1, 3, 50])
def test_a_session_that_is_lost_over_and_over_is_created_over_and_over(forgetful, losses):
    with stiefel.Client(forgetful.address) as client:
        session = session_of(client, "")
        drive = session.drive()
        for call in (session.step, drive.step):
            forgetful.order.clear()
            forgetful.losses = losses
            assert call(7).step == 7
            pauses = list(recreating.pauses())[:losses]
            # The call comes right after the creation, not after a pause in which the session may be lost.
            assert forgetful.order == ["call", *(event for pause in pauses for event in (pause, "create", "call"))]


def test_the_arrays_of_a_scene_come_from_a_session_that_is_created_again(forgetful):
    with stiefel.Client(forgetful.address) as client:
        session = session_of(client, "", left_out=["initial.Q"])
        forgetful.losses = 2
        assert np.array_equal(session.scene["initial"]["Q"], fake.Q)
        first, second, *_ = recreating.pauses()
        assert forgetful.order == ["call", first, "create", "call", second, "create", "call"]


def test_in_the_end_the_loss_is_told(forgetful):
    with stiefel.Client(forgetful.address) as client:
        session = session_of(client, "")
        drive = session.drive()
        for call in (session.step, drive.step):
            forgetful.order.clear()
            forgetful.losses = 10**6
            with pytest.raises(stiefel.NotFound, match="there is no such session"):
                call(7)
            assert forgetful.order.count("create") == recreating.RECOVERIES
            assert sum(event for event in forgetful.order if isinstance(event, float)) == pytest.approx(20.375)


class OtherBuild(fake.Fake):
    """The fake with the numerics id "other"; it takes no checkpoint, and keeps what calls are routed by."""

    routed = None

    def _receive(self, request, context):
        context.send_initial_metadata((("stiefel-numerics-id", "other"),))
        self.routed = dict(context.invocation_metadata()).get("stiefel-session")
        super()._receive(request, context)

    def CreateSession(self, request, context):
        self._receive(request, context)
        return pb.CreateSessionResponse(session=fake.SESSION)


@pytest.fixture
def other_build(tmp_path, monkeypatch):
    monkeypatch.setattr(fake, "Fake", OtherBuild)
    service, server, service.address = fake.serve(tmp_path)
    yield service
    server.stop(None)


def session_of(client, numerics_id, **more):
    message = pb.Session(session_id="fake", numerics_id=numerics_id, **more)
    return stiefel.Session(client._connection, message, True, pb.Scene(step=0.5), owner=True)


def test_another_build_is_not_gone_on_at_silently(other_build):
    with stiefel.Client(other_build.address) as client:
        session = session_of(client, "mine")
        with_arrays = session_of(client, "mine", left_out=["initial.Q"])
        for call in (lambda: session.step(1), lambda: session.trajectory(to=10), lambda: session.drive().step(1),
                     with_arrays.resolved):
            with pytest.raises(stiefel.BuildChanged, match="mine.*other") as caught:
                call()
            assert (caught.value.began_with, caught.value.now, caught.value.reason) == ("mine", "other", "BUILD_CHANGED")
            assert isinstance(caught.value, stiefel.FailedPrecondition) and other_build.routed == "fake"
        assert session_of(client, "other").step(1).step == 1
        assert session_of(client, "").step(1).step == 1, "which did not say"


def test_nor_where_the_session_is_gone(other_build):
    with stiefel.Client(other_build.address) as client:
        other_build.failures = [grpc.StatusCode.NOT_FOUND]
        with pytest.raises(stiefel.BuildChanged):
            session_of(client, "mine").step(1)


def test_but_on_request(other_build):
    with stiefel.Client(other_build.address, any_build=True) as client:
        assert session_of(client, "mine").step(1).step == 1
        assert session_of(client, "mine").trajectory(to=10).samples == 11
