"""How the dual of Eq. 7 is solved (`incsvr.learning.dual` is the way in)."""
