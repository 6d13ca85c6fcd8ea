"""Records an episode for the Rerun viewer. Needs `rerun-sdk`, which nothing else imports."""
