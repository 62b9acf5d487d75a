"""Python clients in threads, a thread a kind of call, whose states are compared with those of the embedded simulation."""
from __future__ import annotations

import collections
import random
import threading
import time
from pathlib import Path
from typing import Any, Callable, Mapping, Optional

import numpy as np

import stiefel
from stiefel._wire.calls import Attempts

STATE = 18  # numbers of a state: Q and M


class Resumptions:
    """Seconds from a failure that a client saw to the next thing it got, of all threads."""

    def __init__(self, monkeypatch: Any):
        self.seconds: list[float] = []
        self._here = threading.local()
        monkeypatch.setattr(Attempts, "again", self._noting(Attempts.again))

    def _noting(self, function: Callable[..., Any]) -> Callable[..., Any]:
        def noted(*arguments: Any, **named: Any) -> Any:
            if getattr(self._here, "since", None) is None:
                self._here.since = time.monotonic()
            return function(*arguments, **named)
        return noted

    def got(self) -> None:
        since = getattr(self._here, "since", None)
        if since is not None:
            self.seconds.append(time.monotonic() - since)
            self._here.since = None


class Use:
    def __init__(self, address: str, reference: str, folder: Path, first: int, count: int, resumptions: Resumptions):
        self.address, self.first, self.count = address, first, count
        self.scene = str(folder / "scene.json")
        self.states = np.fromfile(folder / "states").reshape(count, STATE)
        checkpoint = folder / "checkpoint"
        self.checkpoint = checkpoint.read_bytes() if checkpoint.exists() else b""
        self.reference = stiefel.Client(reference)  # of a server that nobody kills: for forks
        self.resumptions = resumptions
        self.calls: collections.Counter[str] = collections.Counter()
        self.lost: list[str] = []
        self.differing = self.back = 0
        self._random = random.Random(18)

    def run(self, seconds: float) -> None:
        self._end = time.monotonic() + seconds
        threads = [threading.Thread(target=self._work, args=(kind,)) for kind in
                   (self._steps, self._streams, self._drives, self._forks, self._diagnoses, self._summaries, self._deletions)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.reference.close()

    def _work(self, kind: Callable[[stiefel.Client], None]) -> None:
        with stiefel.Client(self.address) as client:
            try:
                kind(client)
            except Exception as error:  # outside of a call
                self.lost.append(f"{kind.__name__}: {error!r}")

    def _call(self, kind: str, work: Callable[[], Any]) -> Any:
        self.calls[kind] += 1
        try:
            answer = work()
            self.resumptions.got()
            return answer
        except stiefel.StiefelError as error:
            self.lost.append(f"{kind}: {error!r}")
            return None

    def _over(self) -> bool:
        return time.monotonic() >= self._end

    def _any(self) -> int:
        return self.first + self._random.randrange(self.count)

    def _same(self, step: int, fields: Mapping[str, Any], index: Optional[int] = None) -> None:
        numbers = [values if index is None else values[index] for values in fields.values()]
        if not np.array_equal(np.concatenate([n.ravel() for n in numbers]), self.states[step - self.first]):
            self.differing += 1

    def _create(self, client: stiefel.Client) -> stiefel.Session:
        return client.create(self.scene, checkpoint=self.checkpoint)

    def _steps(self, client: stiefel.Client) -> None:
        session = self._create(client)
        while not self._over():
            state = self._call("step", lambda: session.step(self._any()))
            if state is not None:
                self._same(state.step, state.fields)

    def _drives(self, client: stiefel.Client) -> None:
        with self._create(client).drive() as drive:
            while not self._over():
                state = self._call("drive", lambda: drive.step(self._any()))
                if state is not None:
                    self._same(state.step, state.fields)

    def _streams(self, client: stiefel.Client) -> None:
        session, last = self._create(client), self.first + self.count - 1

        def stream() -> None:
            following = self.first
            for batch in session.stream(to=last, start=self.first, every=1):
                self.resumptions.got()
                for index, step in enumerate(batch.step.tolist()):
                    if step != following:
                        self.differing += 1
                    self._same(step, batch.fields, index)
                    following = step + 1
            if following != last + 1:
                self.differing += 1
        while not self._over():
            self._call("stream", stream)

    def _forks(self, client: stiefel.Client) -> None:
        session = self._create(client)
        while not self._over():
            fork = self._call("fork", lambda: session.fork(self._any()))
            if fork is None:
                continue
            state = self._call("step of a fork", lambda: fork.step(5))
            with self.reference.create(fork.scene) as same:
                expected = same.step(5)
            if state is not None and not all(np.array_equal(state[name], expected[name]) for name in expected):
                self.differing += 1
            self._call("delete", fork.delete)

    def _diagnoses(self, client: stiefel.Client) -> None:
        session = self._create(client)
        while not self._over():
            diagnosis = self._call("diagnose", lambda: session.diagnose(self._any(), invariants="energy"))
            if diagnosis is not None and not diagnosis.invariants[0].drift < 1e-9:
                self.differing += 1

    def _summaries(self, client: stiefel.Client) -> None:
        session = self._create(client)
        last = {"Q": "last", "M": "last"}
        while not self._over():
            step = self._any()
            summary = self._call("summarize", lambda: session.summarize(step, quantities=last, start=self.first))
            if summary is not None:
                self._same(step, {block: summary[block]["last"] for block in last})

    def _deletions(self, client: stiefel.Client) -> None:
        """A deleted session is there for no later call of its handle."""
        while not self._over():
            session = self._call("create", lambda: self._create(client))
            if session is None:
                continue
            self._call("step", lambda: session.step(self._any()))
            self._call("delete", session.delete)
            try:
                session.step(self._any())
                self.back += 1
            except stiefel.NotFound:
                pass
