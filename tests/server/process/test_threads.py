"""The threads of a server."""
import os


def test_no_thread_polls_what_has_no_connections(serve):
    """gRPC's connections are in one set of descriptors."""
    process = serve("--log-level", "off")
    folder = f"/proc/{process.child.pid}/fd"
    assert sum("eventpoll" in os.readlink(f"{folder}/{each}") for each in os.listdir(folder)) == 1
