"""The health of a learner, and its reports to systemd."""
