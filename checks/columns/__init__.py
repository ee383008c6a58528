"""Columns and buckling, of parts and of the linkage as a frame."""
