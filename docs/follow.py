"""Follows the models of a learner, also one that it joins late: `python follow.py tcp/127.0.0.1:7447`."""

import json
import math
import queue
import sys

import zenoh
from zenoh.ext import HistoryConfig, RecoveryConfig, declare_advanced_subscriber

settings = {"mode": "client", "connect": {"endpoints": [sys.argv[1]]}, "scouting": {"multicast": {"enabled": False}}}
models: queue.Queue[bytes] = queue.Queue()
with zenoh.open(zenoh.Config.from_json5(json.dumps(settings))) as session:
    follower = declare_advanced_subscriber(
        session,
        "leng/yaw/model",
        lambda sample: models.put(sample.payload.to_bytes()),
        history=HistoryConfig(detect_late_publishers=True, max_samples=1),
        recovery=RecoveryConfig(periodic_queries=None, heartbeat=True),
    )
    while True:
        model = json.loads(models.get())
        gamma, support = model["kernel"]["gamma"], model["support"]
        pairs = zip(support["rate"], support["weight"], strict=True)
        damping = sum(weight * math.exp(-gamma * (rate - 0.1) ** 2) for rate, weight in pairs)
        print(f"revision {model['revision']}: {damping:.1f} N m at 0.1 rad/s", flush=True)
