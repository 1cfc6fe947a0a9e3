"""What was traced, applied: effects in force, the torque ledger, comparison on fresh data, promotion."""
