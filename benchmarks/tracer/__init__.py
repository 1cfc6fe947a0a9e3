"""What the tracer names of effects that are hidden: in trials, in missions, live, and in logs with faults."""
