"""Creates a session of a tumbling spacecraft, goes to a step, streams samples, and asks for several states at once:

    python3 example.py [HOST:PORT]
"""
from __future__ import annotations

import asyncio
import sys
from pathlib import Path
from typing import Any

import stiefel.aio

SCENE = Path(__file__).parents[1] / "scenes/tumbling_spacecraft.json"


def show(step: int, quaternion: Any) -> None:
    print(f"step {step}:", *quaternion.ravel())


async def main(address: str) -> None:
    async with stiefel.aio.Client(address) as client, client.create(SCENE) as session:
        state = await session.step(to=100, fields="quaternion")
        show(state.step, state["quaternion"])

        async for batch in session.stream(to=1000, every=250, fields="quaternion"):
            for step, quaternion in zip(batch.step, batch["quaternion"]):
                show(step, quaternion)

        states = await asyncio.gather(*(session.step(to=k, fields="quaternion") for k in (100, 250, 1000)))
        for state in states:
            show(state.step, state["quaternion"])


if __name__ == "__main__":
    asyncio.run(main(sys.argv[1] if len(sys.argv) > 1 else "127.0.0.1:50551"))
