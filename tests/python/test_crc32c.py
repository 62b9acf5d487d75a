"""CRC-32C, and the checksums of messages."""
import numpy as np
import pytest

import fake
import stiefel
from stiefel import v1 as pb
from stiefel.checksums import (verify_conversion, verify_diagnosis, verify_geodesic, verify_sample, verify_session,
                               verify_tradeoff)
from stiefel.crc32c import crc32c


@pytest.mark.parametrize("data, expected", [
    (b"123456789", 0xE3069283),  # the check value of the CRC catalogues
    (bytes(32), 0x8A9136AA), (b"\xff" * 32, 0x62A8AB43), (bytes(range(32)), 0x46DD794E),  # RFC 3720, B.4
    (bytes(range(31, -1, -1)), 0x113FDB5C), (b"", 0),
])
def test_vectors(data, expected):
    assert crc32c(data) == fake.crc32c(data) == expected


@pytest.mark.parametrize("size", [2047, 2048, 2049, 2081, 4096, 32767, 32768, 70_001])
def test_much_data_is_the_definition_s(size):
    data = np.random.default_rng(size).bytes(size)
    assert crc32c(data) == fake.crc32c(data)
    assert crc32c(data[size // 3:], crc32c(data[:size // 3])) == crc32c(data)


def little(*numbers):
    """Integers as uint32, other numbers as float64."""
    return b"".join(np.array(number, "<u4" if isinstance(number, int) else "<f8").tobytes() for number in numbers)


def long(*numbers):
    return np.array(numbers, "<i8").tobytes()


def floats(first, last):
    """first, first + 1, ..., last as float64."""
    return little(*map(float, range(first, last + 1)))


SCENE = pb.Scene(inertia=[1, 2], inertia_u=[3], inertia_v=[4],
                 body=pb.Body(inertia_tensor=[5], moments=[6], attitude=[7], angular_velocity=[8]),
                 initial={"b": pb.Matrix(rows=1, cols=1, values=[11]),
                          "a": pb.Matrix(rows=1, cols=1, values=[9], imaginary=[10])})
FIELD = pb.Field(name="x", value=fake.tensor(np.array([[0.5]])))
MESSAGES = {
    "sample": (verify_sample, pb.Sample(step=3, time=0.25, fields=[FIELD]), long(3) + little(0.25, 0.5)),
    "diagnosis": (verify_diagnosis, pb.DiagnoseResponse(step=3, time=0.25, invariants=[
        pb.Invariant(name="energy", initial=1, value=2, drift=3, scale=4)]), long(3) + little(0.25) + floats(1, 4)),
    "session": (verify_session, pb.Session(scene=SCENE), floats(1, 11)),
    "conversion": (verify_conversion, pb.ConvertResponse(scene=SCENE, scene_arrays=[FIELD], blocks=[FIELD]),
                   floats(1, 11) + little(0.5, 0.5)),
    "setup of a trade-off": (verify_tradeoff, pb.MeasureTradeoffResponse(setup=pb.TradeoffSetup(
        reference_error=1, horizon=2, steps=3, reference_steps=4, budget=5, repeats=6, curves=7)),
        floats(1, 2) + long(3, 4) + little(5.0, 6, 7)),
    "point of a trade-off": (verify_tradeoff, pb.MeasureTradeoffResponse(point=pb.TradeoffPoint(
        method=pb.Method(order=1, substeps=2, tolerance=3), attitude_error=4, momentum_error=5, drift=6, work=7,
        cpu_seconds_per_second=[8, 9], steps_per_second=10, measured_steps=11)),
        little(1, 2) + floats(3, 10) + long(11)),
    "point without errors": (verify_tradeoff, pb.MeasureTradeoffResponse(point=pb.TradeoffPoint(
        drift=1, work=2, steps_per_second=3, measured_steps=4)), floats(1, 3) + long(4)),
    "front of a trade-off": (verify_tradeoff, pb.MeasureTradeoffResponse(front=pb.TradeoffFront(points=[5, 0])),
                             little(5, 0)),
    "geodesic": (verify_geodesic, pb.ConnectResponse(scene=SCENE, trajectory=FIELD), floats(1, 11) + little(0.5)),
}


@pytest.mark.parametrize("name", MESSAGES)
def test_the_order_is_that_of_the_proto(name):
    verify, message, data = MESSAGES[name]
    verify(message, False)  # without a checksum there is nothing to compare
    message.checksum = fake.crc32c(data)
    verify(message, False)
    message.checksum ^= 1
    with pytest.raises(stiefel.CorruptReply, match="the checksum of .* does not match its numbers"):
        verify(message, False)
    message.ClearField("checksum")


DETAILS = pb.DiagnoseResponse(
    step=3, invariants=[pb.Invariant(member=1), pb.Invariant(), pb.Invariant(member=2)], orthogonality=3,
    domain=pb.Domain(h_omega=4, largest_step=5), forms=[6, 7], dirac_brackets=[8], symplectic_defect=9,
    estimated_error=pb.EstimatedError(attitude=10, momentum=11, angle=12, reference_error=13, work=14, run_work=15,
                                      member=16))


@pytest.mark.parametrize("message, data", [
    (DETAILS, little(1, 2) + floats(3, 15) + little(16)),
    (pb.DiagnoseResponse(step=3), b""),
    (pb.DiagnoseResponse(domain=pb.Domain(h_omega=1), estimated_error=pb.EstimatedError(missing="too much work")),
     little(1.0, 0.0, 0.0, 0.0)),
], ids=["all", "none", "absent ones"])
def test_a_diagnosis_has_a_second_checksum_for_its_details(message, data):
    damaged = pb.DiagnoseResponse()
    damaged.CopyFrom(message)
    damaged.details_checksum = fake.crc32c(data)
    verify_diagnosis(damaged, False)
    damaged.forms.append(0.5)
    with pytest.raises(stiefel.CorruptReply, match="the checksum of the diagnosis of step"):
        verify_diagnosis(damaged, False)
