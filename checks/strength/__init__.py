"""Fatigue of a part over its duty: endurance, finite life, the FKM guideline, codes of ranges."""
