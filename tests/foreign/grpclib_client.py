"""Makes the calls that stdin lists as JSON, [{rpc, requests, session}], with grpclib, which speaks HTTP/2 in Python, and
writes for each a line of JSON: the replies as bytes in base64, the status code, the reason.

    python grpclib_client.py HOST PORT FOLDER        (where protoc has put its Python, and that of grpclib's plugin)
"""
import asyncio
import base64
import json
import sys

sys.path.insert(0, sys.argv[3])

from google.protobuf import json_format  # noqa: E402
from google.rpc.error_details_pb2 import ErrorInfo  # noqa: E402
from grpclib.client import Channel  # noqa: E402
from grpclib.exceptions import GRPCError  # noqa: E402
from stiefel.v1.simulation_grpc import SimulationServiceStub  # noqa: E402


async def ask(stub, call):
    method = getattr(stub, call["rpc"])
    requests = [json_format.ParseDict(request, method.request_type()) for request in call["requests"]]
    metadata = {"stiefel-session": call["session"]} if call["session"] else {}
    answer = {"replies": [], "code": "OK", "reason": ""}
    try:
        async with method.open(metadata=metadata) as stream:
            for request in requests[:-1]:
                await stream.send_message(request)
            await stream.send_message(requests[-1], end=True)
            async for reply in stream:
                answer["replies"].append(base64.b64encode(reply.SerializeToString()).decode())
    except GRPCError as error:
        reasons = [detail.reason for detail in error.details or [] if isinstance(detail, ErrorInfo)]
        answer.update(code=error.status.name, reason="".join(reasons))
    return answer


async def main():
    channel = Channel(sys.argv[1], int(sys.argv[2]))
    stub = SimulationServiceStub(channel)
    for call in json.load(sys.stdin):
        print(json.dumps(await ask(stub, call)), flush=True)
    channel.close()


asyncio.run(main())
