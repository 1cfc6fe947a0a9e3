"""The tracer: from the residual of a declared model to the effects that it lacks, with the proof on unseen data."""

from __future__ import annotations

from incsvr.tracing.trace import trace, trace_if_found

__all__ = ["trace", "trace_if_found"]
