"""What is measured: a file each for the studies over `study.py`, and for the commands `table1` and `bench`.

`results/` keeps of each study its last figures with command and date. No other package imports this one.
"""
