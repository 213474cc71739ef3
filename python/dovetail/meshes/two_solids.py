"""Mesh of two steel posts whose platforms touch (the two-solid example): geometry, and tetrahedra by gmsh.

Post 1 stands at the left and reaches over to the right with the upper half of its platform; post 2 is its image under the
half turn about a vertical axis. All lengths in metres; y points up.
"""

import gmsh
import numpy as np

PLANE_Z = -0.015  # of the contact patch
PATCH_X = (0.0035, 0.01)
PATCH_Y = (0.13, 0.135)
BOXES = (  # (corner, edges) of post 1: base, leg, lower and upper half of the platform
    ((-0.08, 0.0, -0.03), (0.08, 0.03, 0.03)),
    ((-0.01, 0.03, -0.03), (0.01, 0.1, 0.03)),
    ((-0.02, 0.13, -0.03), (0.0225, 0.005, 0.015)),
    ((-0.0125, 0.13, -0.015), (0.0225, 0.005, 0.015)),
)
LOADED_POINTS = np.array([(-0.0125, 0.135, 0.0), (-0.02, 0.135, -0.03), (0.026, 0.135, -0.03), (0.0335, 0.135, 0.0)])


def image(points):
    """Half turn (n, 3) -> (n, 3) that carries post 1 to post 2 (and back); it maps the patch to itself."""
    return np.array([0.0135, 0.0, -0.03]) + points * np.array([-1.0, 1.0, -1.0])


def on_patch(points, tolerance=1e-9):
    """Which of the points (n, 3) lie on the contact patch: (n,) bool."""
    x, y, z = points.T
    inside_x = (x > PATCH_X[0] - tolerance) & (x < PATCH_X[1] + tolerance)
    inside_y = (y > PATCH_Y[0] - tolerance) & (y < PATCH_Y[1] + tolerance)
    return inside_x & inside_y & (np.abs(z - PLANE_Z) < tolerance)


def mesh_post(size, divisions):
    """Tetrahedra of post 1 with edges of at most about `size` [m], half of it in the platform.

    divisions: elements along x and y of the contact patch.
    Returns the vertices (n, 3) [m] and the cells (m, 4).
    """
    gmsh.initialize()
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("Mesh.MeshSizeMax", size)
        _build_post(size, divisions)
        gmsh.model.mesh.generate(3)
        tags, coordinates, _ = gmsh.model.mesh.getNodes()
        _, corners = gmsh.model.mesh.getElementsByType(4)
    finally:
        gmsh.finalize()
    used, cells = np.unique(corners, return_inverse=True)
    order = np.argsort(tags)
    rows = order[np.searchsorted(tags, used, sorter=order)]
    return coordinates.reshape(-1, 3)[rows], cells.reshape(-1, 4)


def _build_post(size, divisions):
    """Post 1 as one gmsh volume, with the contact patch a structured face of its own and a platform meshed twice as fine."""
    occ = gmsh.model.occ
    boxes = [(3, occ.addBox(*corner, *edges)) for corner, edges in BOXES]
    body, _ = occ.fuse(boxes[:1], boxes[1:])
    patch = occ.addRectangle(PATCH_X[0], PATCH_Y[0], PLANE_Z, PATCH_X[1] - PATCH_X[0], PATCH_Y[1] - PATCH_Y[0])
    _, (_, ((_, patch),)) = occ.fragment(body, [(2, patch)])
    occ.synchronize()
    for _, edge in gmsh.model.getBoundary([(2, patch)], oriented=False):
        x_min, _, _, x_max, _, _ = gmsh.model.getBoundingBox(1, edge)
        along_x = x_max - x_min > 0.5 * (PATCH_X[1] - PATCH_X[0])
        gmsh.model.mesh.setTransfiniteCurve(edge, divisions[0 if along_x else 1] + 1)
    gmsh.model.mesh.setTransfiniteSurface(patch)
    platform = gmsh.model.getEntitiesInBoundingBox(-1, PATCH_Y[0] - 1e-6, -1, 1, 1, 1, dim=0)
    gmsh.model.mesh.setSize(platform, 0.5 * size)


def mesh_pair(size, divisions):
    """Both posts: vertices (2n, 3) [m] and cells (2m, 4). The posts share no vertex, not even on the patch."""
    vertices, cells = mesh_post(size, divisions)
    return np.vstack([vertices, image(vertices)]), np.vstack([cells, cells + len(vertices)])
