"""What was computed before, kept in files: loads, bodies, meshes, solutions, whole results."""
