"""The page: a client of the bus that serves a learner to a browser with Python's own HTTP server and one HTML file."""
