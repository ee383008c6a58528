"""Where loads act: parametric parts, their meshes, named interfaces and mass properties."""
