"""Online model identification for underwater vehicles by incremental support vector regression.

The mathematics alone: arrays in, arrays out. No bus, no files, no clock. Read top to bottom it is the paper:
B. Wehbe, A. Fabisch, M. M. Krell, "Online Model Identification for Underwater Vehicles through Incremental Support
Vector Regression", IROS 2017. "Eq." and "Section" in the docstrings of this package cite that paper.
"""
