"""Pictures, plots, films and recordings for people."""
