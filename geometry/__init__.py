"""Where loads act: parametric parts, their meshes, named interfaces and mass properties."""

# The system's graphics libraries, which gmsh and VTK need also where nothing is drawn.
INSTALL = "apt-get install libgl1 libegl1 libglu1-mesa libxft2 libxcursor1 libxinerama1 libgomp1"
