"""One file a command, named as the command, and what `fit` and `trace` are made of."""
