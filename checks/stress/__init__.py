"""Stress of a part over its duty on one mesh, and its error bars from mesh to mesh."""
