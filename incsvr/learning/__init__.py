"""The learner of the paper: kernel, dual problem, criteria, policies, model, and what it is compared with."""
