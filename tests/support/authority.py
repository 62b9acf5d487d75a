"""Certificates for tests, made by the program openssl."""
import subprocess
from pathlib import Path
from typing import NamedTuple

EC = ["-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes"]


class Identity(NamedTuple):
    """The paths of a certificate and its key, in PEM."""
    certificate: str
    key: str


class Authority:
    """A certificate authority; `ca` is the path of its own certificate."""

    def __init__(self, folder, name="authority"):
        self.folder = Path(folder) / name
        self.folder.mkdir()
        self.ca = str(self.folder / "ca.pem")
        openssl("req", "-x509", *EC, "-keyout", self.folder / "ca.key", "-out", self.ca, "-days", "2",
                "-subj", f"/CN={name}", "-addext", "basicConstraints=critical,CA:TRUE")

    def issue(self, name="server", hosts=("DNS:localhost", "IP:127.0.0.1"), days=2):
        """Returns a certificate for `hosts` that is valid for `days`; a negative number gives an expired one."""
        certificate, key, request = (str(self.folder / f"{name}.{end}") for end in ("pem", "key", "csr"))
        openssl("req", *EC, "-keyout", key, "-out", request, "-subj", f"/CN={name}",
                "-addext", f"subjectAltName={','.join(hosts)}")
        openssl("x509", "-req", "-in", request, "-CA", self.ca, "-CAkey", self.folder / "ca.key", "-CAcreateserial",
                "-days", days, "-copy_extensions", "copy", "-out", certificate)
        return Identity(certificate, key)


def openssl(*arguments):
    done = subprocess.run(["openssl", *map(str, arguments)], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
