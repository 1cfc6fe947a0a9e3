"""The health of a learner, and its report to ROS 2."""
