"""The page: a learner's status, curve and findings in any browser, served by a client of the bus.

It needs what the vehicle has and nothing else: Python's own HTTP server, one HTML file, no request to anybody.
"""
