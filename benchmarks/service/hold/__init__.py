"""What a learner survives, notices and says: kills, damaged states, restarts, junk, floods, a client that stops."""
