"""Loads of a design's machine: validity, drives, stops, vibration, motion for pictures."""
