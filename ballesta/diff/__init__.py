"""Differences between two designs or two results."""
