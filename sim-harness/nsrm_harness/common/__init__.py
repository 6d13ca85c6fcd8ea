"""Shared by all packages: errors, JSON, worker processes."""
