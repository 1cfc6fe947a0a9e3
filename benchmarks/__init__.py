"""What is measured: Table I, speed against peers, the tracer's confusion matrix. Nobody imports this package."""
