"""Sentences: how they are made from programs, and how they fall into tokens."""
