"""Shows a tumbling body in browsers: an HTTP server that sends the samples of a session as server-sent events.

    python3 gateway.py [--server HOST:PORT] [--port 8080] [--rate SAMPLES_PER_SECOND]

Every browser gets a stream of its own. One that reconnects goes on after the last sample that it has; when it leaves, its
stream is cancelled.
"""
from __future__ import annotations

import argparse
import asyncio
import json
from functools import partial
from pathlib import Path

import stiefel.aio

HERE = Path(__file__).parent
HEAD = "HTTP/1.1 {}\r\nContent-Type: {}; charset=utf-8\r\nCache-Control: no-store\r\nConnection: close\r\n\r\n"
EVENTS = HEAD.format("200 OK", "text/event-stream")
PAGE = HEAD.format("200 OK", "text/html") + (HERE / "index.html").read_text(encoding="utf-8")
NOTHING = HEAD.format("404 Not Found", "text/plain") + "there is / and /samples\n"
LAST = 10**9  # the last step


async def send_samples(writer: asyncio.StreamWriter, session: stiefel.aio.Session, start: int, rate: float) -> None:
    writer.write(EVENTS.encode())
    async for batch in session.stream(to=LAST, start=start, every=1, fields="quaternion"):
        for step, time, quaternion in zip(batch.step.tolist(), batch.time.tolist(), batch["quaternion"]):
            sample = json.dumps({"step": step, "time": time, "quaternion": quaternion.ravel().tolist()})
            writer.write(f"id: {step}\ndata: {sample}\n\n".encode())
            await writer.drain()
            await asyncio.sleep(1 / rate)


async def answer(session: stiefel.aio.Session, rate: float, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
    try:
        request, *lines = (await reader.readuntil(b"\r\n\r\n")).decode("latin-1").split("\r\n")
        headers = {name.lower(): value.strip() for name, _, value in (line.partition(":") for line in lines)}
        path = request.split(" ")[1].partition("?")[0]
        if path == "/samples":
            await send_samples(writer, session, int(headers.get("last-event-id", -1)) + 1, rate)
        else:
            writer.write((PAGE if path == "/" else NOTHING).encode())
            await writer.drain()
    except (OSError, ValueError, IndexError, asyncio.IncompleteReadError, asyncio.LimitOverrunError):
        pass  # the browser has left, or sent what is no request
    finally:
        writer.close()


async def main(options: argparse.Namespace) -> None:
    async with stiefel.aio.Client(options.server) as client, client.create(HERE.parent / "scenes/tumbling_spacecraft.json") as session:
        server = await asyncio.start_server(partial(answer, session, options.rate), "127.0.0.1", options.port)
        print("http://127.0.0.1:{}/".format(server.sockets[0].getsockname()[1]), flush=True)
        async with server:
            await server.serve_forever()


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--server", default="127.0.0.1:50551", help="of the stiefel server")
    parser.add_argument("--port", type=int, default=8080, help="of this HTTP server; 0: any free one")
    parser.add_argument("--rate", type=float, default=30.0, help="samples a second")
    try:
        asyncio.run(main(parser.parse_args()))
    except KeyboardInterrupt:
        pass
