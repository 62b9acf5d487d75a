"""The environment variables of the programs and of this package."""
from __future__ import annotations

import difflib
import os
import re
import warnings

PREFIX = "STIEFEL_"
SERVER = ("GRACE", "IDLE_TIMEOUT", "INSECURE", "LISTEN", "LOG_FORMAT", "LOG_LEVEL", "MAX_CALL_SECONDS",
          "MAX_CONNECTION_AGE", "MAX_SESSIONS", "MEMORY", "METRICS", "PRINCIPAL_MEMORY",
          "PRINCIPAL_SESSIONS", "STORE", "THREADS", "TLS_CERT",
          "TLS_CLIENT_CA", "TLS_KEY", "TOKENS")
KNOWN = (*SERVER, "ADDRESS", "SERVER", "TLS_CA", "TOKEN", "CLI", "SANITIZED")  # the last two are of the tests
# What Kubernetes sets for a service whose name begins with "stiefel".
_OF_KUBERNETES = re.compile(r"(.+_)?(SERVICE_HOST|SERVICE_PORT(_.+)?|PORT_\d+_[A-Z]+(_.+)?)=|(.+_)?PORT=\w+://")
_told: set[str] = set()


def warn_of_unknown() -> None:
    """Warns once of each variable that begins with STIEFEL_ and that neither a program nor this package reads."""
    for name, value in sorted(os.environ.items()):
        short = name.removeprefix(PREFIX)
        if name in _told or short == name or short in KNOWN or _OF_KUBERNETES.match(f"{short}={value}"):
            continue
        _told.add(name)
        near = difflib.get_close_matches(short, KNOWN, n=1)
        hint = f"; did you mean {PREFIX}{near[0]}?" if near else ""
        warnings.warn(f"{name}: unknown variable{hint}", stacklevel=3)
