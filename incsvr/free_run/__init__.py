"""Free runs: what a model says that a vehicle does under its torque alone, held against what it did."""
