"""Certificates for tests, made by the program openssl."""
import subprocess
from datetime import datetime, timedelta, timezone
from pathlib import Path
from typing import NamedTuple

# `openssl ca` takes any dates, `openssl x509` only some. Python 3.13 asks for the identifiers, and for the key usage of the
# authority.
SETTINGS = """[ca]
default_ca = settings
[settings]
database = {folder}/issued
new_certs_dir = {folder}
rand_serial = yes
unique_subject = no
default_md = sha256
policy = names
copy_extensions = copy
x509_extensions = identifiers
[names]
commonName = supplied
[identifiers]
subjectKeyIdentifier = hash
authorityKeyIdentifier = keyid
"""
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
                "-subj", f"/CN={name}", "-addext", "basicConstraints=critical,CA:TRUE",
                "-addext", "keyUsage=critical,keyCertSign,cRLSign")
        (self.folder / "issued").touch()
        (self.folder / "settings").write_text(SETTINGS.format(folder=self.folder))

    def issue(self, name="server", hosts=("DNS:localhost", "IP:127.0.0.1"), days=2):
        """Returns a certificate for `hosts` that is valid for `days`; a negative number gives an expired one."""
        certificate, key, request = (str(self.folder / f"{name}.{end}") for end in ("pem", "key", "csr"))
        openssl("req", *EC, "-keyout", key, "-out", request, "-subj", f"/CN={name}",
                "-addext", f"subjectAltName={','.join(hosts)}")
        now = datetime.now(timezone.utc)
        begin, end = (f"{now + timedelta(days=one):%Y%m%d%H%M%SZ}" for one in (min(days, 0) - 1, days))
        openssl("ca", "-batch", "-notext", "-config", self.folder / "settings", "-cert", self.ca,
                "-keyfile", self.folder / "ca.key", "-in", request, "-startdate", begin, "-enddate", end,
                "-out", certificate)
        return Identity(certificate, key)


def openssl(*arguments):
    done = subprocess.run(["openssl", *map(str, arguments)], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
