"""The two errors that a command answers with one sentence: bad input, and work that could not be done."""


class BadInput(ValueError):
    """The input cannot be used; the message is one clear sentence that names the cure.

    The command line prints it without a traceback and exits with status 2; the bus answers with it.
    """


class Failed(Exception):
    """The input is right, but the work could not be done; the message is one clear sentence.

    The command line prints it without a traceback and exits with status 1.
    """
