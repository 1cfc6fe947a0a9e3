"""The policies that select the learner's samples, over one velocity or several: the paper's, and weighted vectors."""
