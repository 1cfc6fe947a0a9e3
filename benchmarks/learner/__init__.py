"""The curve that is learned: speed, bands, policies, several velocities, forecasts, and sensors that fail."""
