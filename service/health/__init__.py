"""The health of a learner, and its reports to systemd and ROS 2."""
