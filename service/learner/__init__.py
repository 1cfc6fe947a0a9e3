"""One learner: measurements become batches, iterations and answers."""
