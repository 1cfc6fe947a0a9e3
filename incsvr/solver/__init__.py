"""How the dual of Eq. 7 is solved (`incsvr.dual` is the way in)."""
