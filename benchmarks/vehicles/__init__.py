"""Every method on the recordings of vehicles that were measured."""
