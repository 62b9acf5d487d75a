"""Shows how far a sweep is and when it will end: as a bar of tqdm, or on stderr if tqdm is not installed."""
from __future__ import annotations

import sys
import time
from typing import Any

PAUSE = 5.0  #: seconds between two lines


class Progress:
    """Counts finished points and shows them if `wanted`. As a context manager it closes its bar at the end."""

    def __init__(self, points: int, done: int, wanted: bool):
        self._points, self._done, self._wanted = points, done, wanted
        self._begun, self._from, self._said = time.monotonic(), done, 0.0
        self._bar: Any = None
        if wanted:
            try:
                from tqdm import tqdm
            except ImportError:
                return
            self._bar = tqdm(total=points, initial=done, unit=" motions", unit_scale=True)

    def add(self, points: int) -> None:
        self._done += points
        if self._bar is not None:
            self._bar.update(points)
        elif self._wanted and (time.monotonic() > self._said + PAUSE or self._done == self._points):
            self._said = time.monotonic()
            print(self.line(), file=sys.stderr, flush=True)

    def line(self) -> str:
        """Returns, for example, "30 of 100 motions, 12 s left"."""
        spent, added = time.monotonic() - self._begun, self._done - self._from
        left = f", {spent * (self._points - self._done) / added:.0f} s left" if added else ""
        return f"{self._done} of {self._points} motions{left}"

    def __enter__(self) -> Progress:
        return self

    def __exit__(self, *exception: object) -> None:
        if self._bar is not None:
            self._bar.close()
