"""The one error that this project raises for bad input."""


class BadInput(ValueError):
    """What was given cannot be used; the message is one clear sentence that names the cure.

    The command line prints it without a traceback and exits with status 2; the bus answers with it.
    """
