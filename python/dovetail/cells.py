"""Cells of a mesh, in meshio names and VTK node order: their faces, and those that lie outside."""

import numpy as np

EDGES = {
    "tetra": [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)],
    "pyramid": [(0, 1), (1, 2), (2, 3), (3, 0), (0, 4), (1, 4), (2, 4), (3, 4)],
    "wedge": [(0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5)],
    "hexahedron": [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)],
}  # in the order of the mid-side nodes of the quadratic cell
_FACES = {
    "tetra": [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)],
    "pyramid": [(0, 3, 2, 1), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)],
    "wedge": [(0, 2, 1), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5)],
    "hexahedron": [(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)],
}
_CORNERS = {"tetra": 4, "pyramid": 5, "wedge": 6, "hexahedron": 8}
_SOLIDS = {"tetra": ("tetra", False), "tetra10": ("tetra", True), "pyramid": ("pyramid", False), "pyramid13": ("pyramid", True),
           "wedge": ("wedge", False), "wedge15": ("wedge", True), "hexahedron": ("hexahedron", False),
           "hexahedron20": ("hexahedron", True)}
_FLAT = {"triangle": 3, "triangle6": 6, "quad": 4, "quad8": 8}  # a shell cell is a face itself, turned as it was given
ALIASES = {"tetra4": "tetra", "hexahedron8": "hexahedron", "wedge6": "wedge", "pyramid5": "pyramid", "triangle3": "triangle",
           "quad4": "quad"}
WIDTH = {"tetra": 4, "tetra10": 10, "pyramid": 5, "pyramid13": 13, "wedge": 6, "wedge15": 15, "hexahedron": 8, "hexahedron20": 20,
         **_FLAT}  # nodes per cell


def outer_faces(nodes, cells, inside=None):
    """Faces that belong to one cell only, turned outwards.

    Parameters
    ----------
    nodes : (n_nodes, 3) array [m]
    cells : dict of cell type to (m, k) array of node rows; types without faces (lines, points) are passed over
    inside : (n_nodes,) bool, optional
        Only faces all of whose nodes are marked.

    Returns
    -------
    list of (f, k) arrays of node rows, k = 3, 4, 6, 8, one for each k that occurs
    """
    found = {}
    for kind, rows in cells.items():
        for faces, centres in _faces_of(nodes, kind, np.asarray(rows), inside):
            found.setdefault(faces.shape[1], []).append((faces, centres))
    outer = []
    for k in sorted(found):
        faces, centres = (np.concatenate(parts) for parts in zip(*found[k]))
        corners = np.sort(faces[:, :3 if k in (3, 6) else 4], axis=1)
        which = np.unique(corners, axis=0, return_inverse=True)[1].reshape(-1)
        solid = ~np.isnan(centres[:, 0])
        solids, total = (np.bincount(some, minlength=len(faces)) for some in (which[solid], which))
        chosen = np.flatnonzero(np.where(solid, solids[which] == 1, total[which] == 1))  # a shell coating a solid hides no face of it
        if chosen.size:
            outer.append(_outwards(nodes, faces[chosen], centres[chosen]))
    return outer


def _faces_of(nodes, kind, rows, inside):
    """Arrays (f, k) of all faces of cells of one kind, each with a point inside its cell (f, 3), nan where there is no inside."""
    if kind in _FLAT:
        kept = rows if inside is None else rows[inside[rows].all(axis=1)]
        yield kept, np.full((len(kept), 3), np.nan)
    if kind not in _SOLIDS:
        return
    shape, quadratic = _SOLIDS[kind]
    place = {frozenset(edge): _CORNERS[shape] + i for i, edge in enumerate(EDGES[shape])}
    for corners in _FACES[shape]:
        columns = list(corners)
        if quadratic:
            columns += [place[frozenset((a, b))] for a, b in zip(corners, corners[1:] + corners[:1])]
        chosen = slice(None) if inside is None else inside[rows[:, columns]].all(axis=1)
        yield rows[chosen][:, columns], nodes[rows[chosen][:, :_CORNERS[shape]]].mean(axis=1)


def _outwards(nodes, faces, centres):
    """Cells may be given in either orientation; a face whose normal looks towards its cell is turned round."""
    corners = 3 if faces.shape[1] in (3, 6) else 4
    X = nodes[faces[:, :corners]]
    normal = np.cross(X[:, 1] - X[:, 0], X[:, -1] - X[:, 0])
    wrong = np.einsum("fi,fi->f", normal, X.mean(axis=1) - centres) < 0
    back = np.r_[0, np.arange(corners - 1, 0, -1)]  # 0 3 2 1
    if faces.shape[1] > corners:
        back = np.r_[back, np.arange(2 * corners - 1, corners - 1, -1)]  # side 0-1 becomes side 1-0, the last one
    faces = faces.copy()
    faces[wrong] = faces[wrong][:, back]
    return faces
