"""The application of traced effects: effects in force, torque ledger, comparison on fresh data, proof."""
