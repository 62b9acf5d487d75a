"""Ends a worker of a process pool when its parent was killed.

Otherwise the worker would wait for tasks forever: the pipe from which it reads stays open, because the other workers
have inherited the other end.
"""
from __future__ import annotations

import multiprocessing
import os
import signal
import threading
import time

PAUSE = 1.0  #: seconds between two checks
_watched = 0  # the id of the process in which the watching thread runs; 0: none


def end_with_parent() -> None:
    """Starts a thread that sends SIGTERM to this process when its parent is gone. Does nothing in a process that
    multiprocessing did not start."""
    global _watched
    parent = multiprocessing.parent_process()
    if parent is None or parent.pid is None or _watched == os.getpid():
        return
    _watched = os.getpid()
    threading.Thread(target=_watch, args=[parent.pid], name="stiefel parent", daemon=True).start()


def _watch(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(PAUSE)
    os.kill(os.getpid(), signal.SIGTERM)
