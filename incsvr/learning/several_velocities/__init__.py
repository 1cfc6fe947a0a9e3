"""What only damping over several velocities needs, d(ν): the paper leaves it for later (Section V)."""
