"""The durable state: the learner's memory and the history of its published revisions."""
