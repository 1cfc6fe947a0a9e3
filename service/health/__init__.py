"""How the learner does, and what systemd and ROS 2 are told of it."""
