"""Damping over several velocities, d(ν): what Section V of the paper leaves for later."""
