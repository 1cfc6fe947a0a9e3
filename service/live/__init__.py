"""Live tracing: the process beside the learner, the ledger, effects in force."""
