"""The configuration: its sections, where it comes from, how it is written."""
