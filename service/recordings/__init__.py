"""Recordings: our form, logs of others read as recordings, archives, samples made of them."""
