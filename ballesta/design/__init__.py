"""From a design file to a design: reading, overrides, what is wrong with it."""
