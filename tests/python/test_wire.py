"""What the client makes of gRPC's words and of the details of errors."""
import socket
from types import SimpleNamespace

import grpc
import pytest

import stiefel
from stiefel import v1 as pb
from stiefel._wire import failures


@pytest.mark.parametrize("grpc_says, plain", [
    ("DNS resolution failed for host:1: C-ares status is not ARES_SUCCESS qtype=A name=host is_balancer=0: "
     "Domain name not found", "cannot reach host:1: the name is unknown"),
    ("errors resolving host:1: [field:hostname lookup error:address lookup failed for host:1: C-ares status is not "
     "ARES_SUCCESS qtype=A name=host is_balancer=0: Domain name not found]", "cannot reach host:1: the name is unknown"),
    ("failed to connect to all addresses; last error: UNKNOWN: ipv6:%5B::1%5D:7: Failed to connect to remote host: "
     "Connection refused", "cannot reach [::1]:7: the connection is refused, nothing listens there"),
    # As gRPC 1.51 and 1.85 say it.
    *((f"failed to connect to all addresses; last error: UNKNOWN: ipv4:10.0.0.1:7: {said}", f"cannot reach 10.0.0.1:7: {plain}")
      for said, plain in {
          "Ssl handshake failed: SSL_ERROR_SSL: error:0A000086:SSL routines::certificate verify failed": "its certificate is not trusted",
          "Tls handshake failed (TSI_PROTOCOL_FAILURE): SSL_ERROR_SSL: error:1000007d:SSL routines:OPENSSL_internal:"
          "CERTIFICATE_VERIFY_FAILED: unable to get local issuer certificate: OK": "its certificate is not trusted",
          "Ssl handshake failed: SSL_ERROR_SSL: error:0A00010B:SSL routines::wrong version number": "it does not speak TLS",
          "Tls handshake failed (TSI_PROTOCOL_FAILURE): SSL_ERROR_SSL: error:100000f7:SSL routines:OPENSSL_internal:"
          "WRONG_VERSION_NUMBER: Invalid certificate verification context: OK": "it does not speak TLS",
          "Custom verification check failed with error: UNAUTHENTICATED: Hostname Verification Check failed.":
          "its certificate has another name",
          "Trying to connect an http1.x server": "nothing that speaks gRPC answers there",
          "Failed parsing HTTP/2 (Expected SETTINGS frame as the first frame, got frame type 80)": "nothing that speaks gRPC answers there",
          "Socket closed": "it closes the connection", "recvmsg:Connection reset by peer": "it closes the connection"}.items()),
    ("Socket closed", "the connection to the server broke"), ("Stream removed", "the connection to the server broke"),
    ("Received RST_STREAM with error code 11", "the server or a proxy before it refuses the call as too much: the call's metadata, "
     "such as its token, is too large, or too many calls or bytes come at once"),
    ("Received http2 header with status: 404", "a web server answers there, not a stiefel server"),
    ("session_id: x: there is no such session", "session_id: x: there is no such session"),
])
def test_grpcs_words_are_translated(grpc_says, plain):
    assert failures.in_plain_words(grpc_says) == plain


def test_a_name_of_two_addresses_of_which_one_accepts():
    """gRPC tells of the last address alone, where nothing listens."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        name = f"localhost:{server.getsockname()[1]}"
        refused = f"failed to connect to all addresses; last error: UNKNOWN: ipv6:%5B::1%5D:{name[10:]}: Connection refused"
        assert failures.in_plain_words(refused, False, name) == (
            f"cannot reach {name}: it closes the connection, as a server with TLS does to a client without: give `tls`")
        assert failures.in_plain_words(refused, True, name) == (
            f"cannot reach {name}: it accepts the connection, and then the TLS handshake fails")
    assert failures.in_plain_words(refused, False, name).endswith("]:" + name[10:] + ": the connection is refused, nothing listens there")


def test_a_quota_is_told_with_the_time_to_wait():
    status = pb.Status(code=8, message="too many sessions")
    quota = pb.QuotaFailure(violations=[pb.QuotaFailure.Violation(subject="sessions", description="1025: at most 1024")])
    retry = pb.RetryInfo()
    retry.retry_delay.FromMilliseconds(1500)
    for name, detail in (("QuotaFailure", quota), ("RetryInfo", retry)):
        status.details.add(type_url=f"type.googleapis.com/google.rpc.{name}", value=detail.SerializeToString())
    def of_call(*trailing):
        return failures.from_rpc_error(SimpleNamespace(code=lambda: grpc.StatusCode.RESOURCE_EXHAUSTED, details=lambda: "too many sessions",
                                                       trailing_metadata=lambda: trailing))
    for error in (failures.from_status(status), of_call(("grpc-status-details-bin", status.SerializeToString()))):
        assert isinstance(error, stiefel.ResourceExhausted) and str(error) == "too many sessions"
        assert error.quota == (stiefel.Violation("sessions", "1025: at most 1024"),) and error.retry_delay == 1.5
    for details in ((), (("grpc-status-details-bin", b"\xff"),)):
        assert of_call(*details).retry_delay is None and str(of_call(*details)) == "too many sessions"
