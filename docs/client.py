"""Sends two measurements, and asks for health and damping: `python client.py tcp/127.0.0.1:7447`."""

import json
import sys
import time

import zenoh

endpoint, prefix = sys.argv[1], "leng/yaw"
settings = {"mode": "client", "connect": {"endpoints": [endpoint]}, "scouting": {"multicast": {"enabled": False}}}
with zenoh.open(zenoh.Config.from_json5(json.dumps(settings))) as session:

    def put(key: str, **fields: object) -> None:
        session.put(f"{prefix}/{key}", json.dumps(fields), encoding="application/json")

    def ask(selector: str) -> None:
        for reply in session.get(f"{prefix}/{selector}", timeout=5.0):
            answer = reply.ok or reply.err
            print(selector, json.loads(answer.payload.to_string()))

    put("rate", t=[time.monotonic() - 0.02, time.monotonic()], value=[0.081, 0.083])
    put("torque", t=time.monotonic(), value=31.5)
    ask("health")
    ask("damping?rate=0.1")
