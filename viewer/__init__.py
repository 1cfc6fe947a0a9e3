"""Rerun, and only here: the live viewer and the recording for review."""
