"""The steps of `incsvr.tracing`, from the recordings to the proof, one a file."""
