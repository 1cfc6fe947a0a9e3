"""The forward form: each rise of the yaw rate predicted from what is known before it."""
