"""Store of computed stages in files: loads, bodies, meshes, solutions, whole results."""
