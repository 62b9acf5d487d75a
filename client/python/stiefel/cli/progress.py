"""Where the run of a session stands: shown on a terminal, and told when the user interrupts it."""
from __future__ import annotations

import sys
import threading
from typing import Any, Optional

from stiefel.cli.interrupt import Interrupted
from stiefel.errors import StiefelError


class Progress:
    """A context manager around a run up to step `to`. On a terminal it shows a bar of tqdm after one second. It adds to an
    Interrupted which step was reached, as far as the server knows."""

    def __init__(self, client: Any, session: Any, to: int):
        self._client, self._session, self._to = client, session, to
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._show, daemon=True)

    def __enter__(self) -> Progress:
        if sys.stderr.isatty():
            self._thread.start()
        return self

    def __exit__(self, kind: Any, exception: Optional[BaseException], *_: object) -> None:
        self._over.set()
        if self._thread.is_alive():
            self._thread.join()
        if isinstance(exception, Interrupted):
            exception.how_far = f"at step {self._step()} of {self._to}"

    def _step(self) -> int:
        told: int = self._session._calls.told
        try:
            held: list[int] = [*self._client.get(self._session.id)._message.cached_steps]
        except StiefelError:
            return told  # the call that is watched fails with a better message
        return max([told, *(step for step in held if step <= self._to)])

    def _show(self) -> None:
        if self._over.wait(1.0):
            return
        try:
            from tqdm import tqdm
        except ImportError:
            return
        with tqdm(total=self._to, unit=" steps", unit_scale=True, leave=False) as bar:
            while not self._over.wait(0.5):
                bar.update(self._step() - bar.n)
