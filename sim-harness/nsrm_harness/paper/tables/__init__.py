"""The paper's tables, and more, from nothing to a report.

`study` says what is made, `run` makes it (data, models, baselines, metrics) and goes on where
it was broken off, `compare` what they are compared with, `results` holds the figures, `paper` the
paper's own, `figures` and `report` tell them to people. Models are judged through the core alone.
"""
