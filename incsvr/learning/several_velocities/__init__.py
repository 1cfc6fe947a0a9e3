"""The parts that only damping over several velocities needs, d(ν), the paper's future work (Section V)."""
