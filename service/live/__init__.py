"""Live tracing: the process beside the learner, its states, and the ledger of what it found."""
