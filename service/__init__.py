"""The learner on the bus: Zenoh, configuration, wire forms, durable state, command line."""
