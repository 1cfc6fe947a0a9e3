"""What survives a crash: the learner's memory and the history of what it published."""
