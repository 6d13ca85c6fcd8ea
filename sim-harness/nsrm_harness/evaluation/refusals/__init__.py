"""Generates sentences that must be refused, and measures how many are."""
