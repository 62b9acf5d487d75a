"""Ends the worker of a process pool whose parent was killed.

Such a worker waits for tasks for ever: the pipe that it reads from stays open, because the other workers have inherited
its other end.
"""
from __future__ import annotations

import multiprocessing
import os
import signal
import threading
import time

PAUSE = 1.0  #: seconds between two looks
_watched = 0  # the process that has a thread for it


def end_with_parent() -> None:
    """From now on SIGTERM for this process when its parent is gone; nothing where multiprocessing did not start it."""
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
