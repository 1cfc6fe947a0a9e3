"""What is measured, a room each for the paper's claims, the tracer, the learner, the service and the measured vehicles.

`results/` keeps of each study its last figures with command and date. No other package imports this one.
"""
