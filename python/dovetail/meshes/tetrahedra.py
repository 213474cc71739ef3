"""Ten-node tetrahedra with named node sets, out of gmsh or from four-node ones."""

from dataclasses import dataclass, field

import gmsh
import numpy as np

EDGES = np.array([(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)])  # whose middles are nodes 4 to 9, in VTK's order
GMSH_TO_VTK = [0, 1, 2, 3, 4, 5, 6, 7, 9, 8]
TETRAHEDRON_4, TETRAHEDRON_10, TRIANGLE_3 = 4, 11, 2  # gmsh's numbers of these types


@dataclass(frozen=True)
class Tetrahedra:
    """Mesh of ten-node tetrahedra, whole in one process."""

    nodes: np.ndarray  # (n_nodes, 3) [m]
    cells: np.ndarray  # (n_cells, 10) node rows, in VTK's order
    node_sets: dict = field(default_factory=dict)  # name -> (k,) node rows

    @classmethod
    def straight(cls, vertices, cells, node_sets=None):
        """From four-node tetrahedra (n_cells, 4): the new nodes lie in the middles of the edges."""
        edges = np.sort(cells[:, EDGES], axis=2).reshape(-1, 2)
        ends, rows = np.unique(edges, axis=0, return_inverse=True)
        middles = len(vertices) + rows.reshape(-1, 6)
        return cls(np.vstack([vertices, vertices[ends].mean(axis=1)]), np.hstack([cells, middles]), node_sets or {})

    def straightened(self):
        """The same with straight edges around every element that curved faces bend too much: jacobian below a tenth of its largest."""
        nodes = self.nodes.copy()
        while True:
            mesh = Tetrahedra(nodes.copy(), self.cells, self.node_sets)
            jacobians = mesh.jacobians()
            bent = self.cells[jacobians.min(axis=1) < 0.1 * jacobians.max(axis=1)]
            nodes[bent[:, 4:]] = nodes[bent[:, EDGES]].mean(axis=2)
            if np.array_equal(nodes, mesh.nodes):
                return mesh

    def jacobians(self):
        """Determinants (n_cells, 10) of the map from the unit tetrahedron, at its nodes: 6 x volume where sides are straight [m^3]."""
        return np.linalg.det(np.einsum("pia,cix->cpax", shape_gradients(), self.nodes[self.cells]))


def shape_gradients():
    """(10 places, 10 shapes, 3): gradients of the quadratic shape functions at the nodes of the unit tetrahedron."""
    corners = np.vstack([np.zeros(3), np.eye(3)])
    places = np.vstack([corners, corners[EDGES].mean(axis=1)])
    weights = np.column_stack([1 - places.sum(axis=1), places])  # barycentric coordinates L
    slopes = np.vstack([-np.ones(3), np.eye(3)])  # of L
    at_corners = (4 * weights[:, :, None] - 1) * slopes
    i, j = EDGES.T
    at_middles = 4 * (weights[:, i, None] * slopes[j] + weights[:, j, None] * slopes[i])
    return np.concatenate([at_corners, at_middles], axis=1)


def tetrahedra_of_gmsh(sets):
    """The second-order mesh of gmsh's present model.

    sets : dict
        Name -> list of (dimension, tag) of entities whose nodes make the set.
    """
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    _, corners = gmsh.model.mesh.getElementsByType(TETRAHEDRON_10)
    used, cells = np.unique(corners, return_inverse=True)
    order = np.argsort(tags)
    nodes = coordinates.reshape(-1, 3)[order[np.searchsorted(tags, used, sorter=order)]]
    node_sets = {}
    for name, entities in sets.items():
        found = [gmsh.model.mesh.getNodes(*entity, includeBoundary=True)[0] for entity in entities]
        node_sets[name] = np.searchsorted(used, np.unique(np.concatenate(found)))
    return Tetrahedra(nodes, cells.reshape(-1, 10)[:, GMSH_TO_VTK], node_sets)


def unknowns(clamped):
    """Displacements that gmsh's present linear mesh will have when made quadratic, without those on the faces `clamped` (tags)."""
    _, corners = gmsh.model.mesh.getElementsByType(TETRAHEDRON_4)
    held = np.concatenate([gmsh.model.mesh.getElementsByType(TRIANGLE_3, face)[1] for face in clamped])
    return 3 * (_quadratic_nodes(corners.reshape(-1, 4), EDGES) - _quadratic_nodes(held.reshape(-1, 3), EDGES[:3]))


def _quadratic_nodes(cells, edges):
    """Number of corners and edges; an edge is a pair of numbers in one."""
    ends = np.sort(cells[:, edges].reshape(-1, 2), axis=1)
    return len(np.unique(cells)) + len(np.unique(ends[:, 0] * (ends.max() + 1) + ends[:, 1]))
