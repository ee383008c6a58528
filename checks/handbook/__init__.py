"""Handbook formulas without finite elements: lugs, pins, columns, notches, Hertz contact."""
