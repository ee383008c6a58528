"""Checks of a part: loads on it, models of its stress, verdicts and their derivations."""
