"""Reads a log, learns the damping curve, asks what the model lacks, and drives a rate with the curve.

Run it beside a log: `incsvr demo --log dive.csv`, then `python example.py dive.csv 350`.
"""

import sys

import numpy as np

import incsvr

log, inertia = incsvr.read(sys.argv[1]), float(sys.argv[2])

learned = incsvr.fit(log, inertia=inertia).to_dict()
curve = learned["curve"]
print(f"learned from {learned['samples']} samples, {learned['support_vectors']} support vectors")

found = incsvr.trace(log, inertia=inertia).to_dict()
print(found["headline"])

# Feed-forward: the torque that holds a yaw rate is the damping there.
for rate in (0.05, 0.1, 0.15):
    torque = np.interp(rate, curve["rate"], curve["damping"])
    print(f"{rate:.2f} rad/s needs {torque:.1f} N m")
