"""The trace on the engine: effects of `incsvr.model` in the contract's words, with their proof on unseen data."""
