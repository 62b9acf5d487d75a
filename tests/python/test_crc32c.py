"""CRC-32C, and the checksums of messages."""
import numpy as np
import pytest

import fake
import stiefel
from stiefel import v1 as pb
from stiefel.checksums import verify_conversion, verify_diagnosis, verify_geodesic, verify_sample, verify_session
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
    return np.array(numbers, "<f8").tobytes()


SCENE = pb.Scene(inertia=[1, 2], inertia_u=[3], inertia_v=[4],
                 body=pb.Body(inertia_tensor=[5], moments=[6], attitude=[7], angular_velocity=[8]),
                 initial={"b": pb.Matrix(rows=1, cols=1, values=[11]),
                          "a": pb.Matrix(rows=1, cols=1, values=[9], imaginary=[10])})
FIELD = pb.Field(name="x", value=fake.tensor(np.array([[0.5]])))
MESSAGES = {
    "sample": (verify_sample, pb.Sample(step=3, time=0.25, fields=[FIELD]), np.int64(3).tobytes() + little(0.25, 0.5)),
    "diagnosis": (verify_diagnosis, pb.DiagnoseResponse(step=3, time=0.25, invariants=[
        pb.Invariant(name="energy", initial=1, value=2, drift=3, scale=4)]), np.int64(3).tobytes() + little(0.25, 1, 2, 3, 4)),
    "session": (verify_session, pb.Session(scene=SCENE), little(*range(1, 12))),
    "conversion": (verify_conversion, pb.ConvertResponse(scene=SCENE, scene_arrays=[FIELD], blocks=[FIELD]),
                   little(*range(1, 12), 0.5, 0.5)),
    "geodesic": (verify_geodesic, pb.ConnectResponse(scene=SCENE, trajectory=FIELD), little(*range(1, 12), 0.5)),
}


@pytest.mark.parametrize("name", MESSAGES)
def test_the_order_is_that_of_the_proto(name):
    verify, message, data = MESSAGES[name]
    verify(message)  # without a checksum there is nothing to compare
    message.checksum = fake.crc32c(data)
    verify(message)
    message.checksum ^= 1
    with pytest.raises(stiefel.CorruptReply, match="the checksum of .* does not match its numbers"):
        verify(message)
    message.ClearField("checksum")
