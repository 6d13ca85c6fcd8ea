"""What the core makes of cameras that are calibrated, and of those that are not."""
