"""Asks a learner for the torque that a planned yaw rate needs: `python plan.py tcp/127.0.0.1:7447`."""

import json
import sys

import zenoh

settings = {"mode": "client", "connect": {"endpoints": [sys.argv[1]]}, "scouting": {"multicast": {"enabled": False}}}
plan = {"t": [0.0, 2.0, 4.0, 6.0], "rate": [0.0, 0.1, 0.1, 0.0]}
with zenoh.open(zenoh.Config.from_json5(json.dumps(settings))) as session:
    for reply in session.get("leng/yaw/feedforward", payload=json.dumps(plan), timeout=5.0):
        answer = json.loads((reply.ok or reply.err).payload.to_string())
        print(answer.get("torque", answer), *answer.get("told", []))
