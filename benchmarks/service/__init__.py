"""The learner as a process: speed and cost on the bus, fleets, long voyages, and what it survives."""
