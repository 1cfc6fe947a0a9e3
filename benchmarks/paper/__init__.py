"""Table I and Fig. 7 anew, the grid search of Section IV-B, and what the paper's text gives where we differ from it."""
