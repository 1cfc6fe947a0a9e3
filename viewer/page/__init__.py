"""The page: a client of the bus that serves a learner's status, curve and effects to a browser.

It needs what the vehicle has and nothing else: Python's own HTTP server, one HTML file, no request to anybody.
"""
