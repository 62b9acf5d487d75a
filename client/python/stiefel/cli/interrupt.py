"""Signals that end the program: it says how far it got, leaves no incomplete file, and ends by the signal."""
from __future__ import annotations

import os
import signal
import sys
from typing import Any, NoReturn

PATIENCE = 3  #: seconds after which a program that cannot stop by itself ends

_received: list[int] = []


class Interrupted(KeyboardInterrupt):
    """A signal asked the program to end."""

    how_far = ""  #: "at step 7 of 100"


def catch() -> None:
    """From now on SIGINT, SIGTERM and SIGHUP, unless the caller ignores them, raise Interrupted in the main thread. A second
    one ends the process."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, _interrupt)


def _interrupt(number: int, frame: Any) -> None:
    if _received:
        end()
    _received.append(number)
    signal.signal(signal.SIGALRM, lambda *_: end())
    signal.alarm(PATIENCE)
    raise Interrupted


def end(how_far: str = "") -> NoReturn:
    """Ends the process by the signal that it received."""
    os.write(2, f"stiefel: interrupted{how_far and ' '}{how_far}\n".encode())
    signal.signal(_received[0], signal.SIG_DFL)
    os.kill(os.getpid(), _received[0])
    sys.exit(128 + _received[0])
