"""Which samples the learner keeps, over one velocity or several: the paper's policy, and one of weighted vectors."""
