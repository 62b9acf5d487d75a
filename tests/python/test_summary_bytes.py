"""Bytes on the wire of a summary beside those of a stream of every step, counted between client and server."""
import socket
import threading

import stiefel

STEPS = 20_000
SCENE = {"system": "rigid_body", "step": 0.02, "method": {"name": "preprocessed_variational", "order": 10},
         "body": {"moments": [1, 2, 3], "angular_velocity": [0.1, 1, 0.1]}}


class Counting:
    """Passes connections on to a server, and counts the bytes in both directions."""

    def __init__(self, address):
        self.server, self.bytes = address.removeprefix("unix:"), 0
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.address = f"127.0.0.1:{self.listener.getsockname()[1]}"
        threading.Thread(target=self._accept, daemon=True).start()

    def _accept(self):
        while True:
            try:
                near = self.listener.accept()[0]
            except OSError:  # closed
                return
            far = socket.socket(socket.AF_UNIX)
            far.connect(self.server)
            for source, sink in ((near, far), (far, near)):
                threading.Thread(target=self._pass, args=(source, sink), daemon=True).start()

    def _pass(self, source, sink):
        try:
            while data := source.recv(1 << 16):
                self.bytes += len(data)
                sink.sendall(data)
        except OSError:
            pass
        for end in (source, sink):
            end.close()

    def of(self, call):
        before = self.bytes
        call()
        return self.bytes - before


def test_a_summary_takes_a_thousandth_of_the_bytes_of_a_stream():
    with stiefel.Server.start() as server:
        wire = Counting(server.address)
        with wire.listener, stiefel.Client(wire.address) as client, client.create(SCENE) as session:
            session.step(0)  # the connection is up, its headers known
            streamed = wire.of(lambda: session.trajectory(to=STEPS, fields=["quaternion", "M"]))
            reduced = wire.of(lambda: session.summarize(to=STEPS, quantities={"energy": ["drift"], "quaternion": ["last"]}))
    assert streamed > STEPS * (4 + 9) * 8
    assert 0 < reduced <= 1e-3 * streamed, (reduced, streamed)
