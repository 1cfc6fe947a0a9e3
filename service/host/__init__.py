"""A learner as a process: the node, its bus, its state and live tracing together."""
