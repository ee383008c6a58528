"""Contact of pins in bores, condensed to the bore: what presses where is solved, not assumed."""
