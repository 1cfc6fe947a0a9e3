"""The command line: the table of commands, their parser, what they print."""
