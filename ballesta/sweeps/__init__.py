"""Variations of a design: sweeps, thresholds, many variations by formula."""
