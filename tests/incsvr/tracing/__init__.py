"""Tests of the trace on the engine."""
