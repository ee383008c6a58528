"""Bodies and meshes from the store."""

from math import inf

from checks.store.store import Store
from geometry.cad_body import Skin, SolidBody, cad_body, cad_skin
from geometry.mesh import Mesh
from geometry.meshing import Buildable, mesh_shape
from geometry.sizing import SizeField

_PACKAGES = ("geometry",)


def stored_body(store: Store | None, shape: Buildable) -> SolidBody:
    """Return what the CAD kernel knows of a shape; raises MeshError."""
    if store is None:
        return cad_body(shape)
    return store.remember("body", _PACKAGES, shape, lambda: cad_body(shape))


def stored_skin(store: Store | None, shape: Buildable) -> Skin:
    """Return a coarse surface of a shape, to draw it; raises MeshError."""
    if store is None:
        return cad_skin(shape)
    return store.remember("skin", _PACKAGES, shape, lambda: cad_skin(shape))


def stored_mesh(
    store: Store | None,
    shape: Buildable,
    fineness: float,
    sizes: SizeField | None,
    most_unknowns: float = inf,
) -> Mesh:
    """Return the mesh of a shape, as mesh_shape does; raises MeshError."""

    def mesh() -> Mesh:
        return mesh_shape(shape, fineness=fineness, sizes=sizes, most_unknowns=most_unknowns)

    if store is None:
        return mesh()
    return store.remember("mesh", _PACKAGES, (shape, fineness, sizes), mesh)
