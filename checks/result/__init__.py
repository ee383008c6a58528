"""Checks, gates, derivations and verdicts as plain types, and how numbers are written."""
