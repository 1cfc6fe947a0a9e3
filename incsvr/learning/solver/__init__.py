"""The solver of the dual of Eq. 7, called by `incsvr.learning.dual`."""
