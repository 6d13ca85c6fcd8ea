"""What every package uses: errors, JSON, worker processes."""
