"""What the readers of all streams share: checkpoints that come in parts, and a progress bar."""
from __future__ import annotations

from typing import Any, Optional

from stiefel import v1 as pb
from stiefel._results.extras import imported
from stiefel.errors import CorruptReply


class CheckpointParts:
    """Joins the parts of a checkpoint, which come in order."""

    def __init__(self) -> None:
        self._parts: list[bytes] = []

    def take(self, part: pb.CheckpointPart) -> bytes:
        """Returns the whole checkpoint when `part` is its last part, else nothing. Raises CorruptReply if the part does
        not continue the part before it."""
        if part.offset == 0:
            self._parts = []
        begun = sum(map(len, self._parts))
        if part.offset != begun or begun + len(part.data) > part.size:
            raise CorruptReply(f"a part of the checkpoint of step {part.step} is missing")
        self._parts.append(part.data)
        return b"".join(self._parts) if begun + len(part.data) >= part.size else b""


class _NoBar:
    n = 0

    def __enter__(self) -> _NoBar:
        return self

    def __exit__(self, *exception: object) -> None:
        pass

    def update(self, steps: int) -> None:
        pass


def progress_bar(count: Optional[int], wanted: bool, unit: str) -> Any:
    """Returns a bar of tqdm for `count` units, None for an unknown number, as a context manager with `update(number)`; one that shows nothing if none
    is wanted."""
    if not wanted:
        return _NoBar()
    return imported("tqdm", "progress").tqdm(total=count, unit=unit, unit_scale=True)
