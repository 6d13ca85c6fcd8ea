"""Reproduces the paper's tables, and more, from scratch to a report.

`study` defines what is made; `run_tables` makes it (data, models, baselines, metrics) and resumes
an interrupted run; `compare` makes the variants to compare with; `results` holds the figures and
`published_figures` the paper's own; `tables_report`, `plots` and their helpers present them. Models
are judged only through the core.
"""
