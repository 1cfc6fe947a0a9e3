"""Which samples the learner keeps: the paper's policy, and one whose vectors stand for many samples."""
