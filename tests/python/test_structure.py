"""Structures: clamping, loads, named surfaces of every kind of cell, refusals; faces, areas and normals of surfaces."""

import itertools

import brick
import numpy as np
import pytest
import scipy.sparse as sp
from lattice import lattice

from dovetail import Structure, Surface, faces
from dovetail.cells import outer_faces

CORNERS = {"tetra": [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)],
           "pyramid": [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1)],
           "wedge": [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (0, 1, 1)],
           "hexahedron": [tuple(c) for c in brick.CORNERS]}  # VTK's reference cells
EDGES = {"tetra": "01 12 20 03 13 23", "pyramid": "01 12 23 30 04 14 24 34", "wedge": "01 12 20 34 45 53 03 14 25",
         "hexahedron": "01 12 23 30 45 56 67 74 04 15 26 37"}
VOLUME = {"tetra": 1 / 6, "pyramid": 1 / 3, "wedge": 1 / 2, "hexahedron": 1.0}
AREA = {"tetra": 1.5 + 3**0.5 / 2, "pyramid": 1 + 1 + 2**0.5, "wedge": 1 + 2 + 2**0.5, "hexahedron": 6.0}
QUADRATIC = {"tetra": "tetra10", "pyramid": "pyramid13", "wedge": "wedge15", "hexahedron": "hexahedron20"}


def one_cell(kind, quadratic, mirrored=False):
    nodes = np.array(CORNERS[kind], dtype=float)
    if quadratic:
        nodes = np.vstack([nodes, [(nodes[int(a)] + nodes[int(b)]) / 2 for a, b in EDGES[kind].split()]])
    if mirrored:
        nodes = nodes * [1, 1, -1]
    return structure_of(nodes, {QUADRATIC[kind] if quadratic else kind: [np.arange(len(nodes))]})


def structure_of(nodes, cells, **more):
    n = 3 * len(nodes)
    return Structure(sp.identity(n, format="csr"), sp.identity(n, format="csr"), nodes, np.repeat(np.arange(len(nodes)), 3),
                     np.tile([0, 1, 2], len(nodes)), cells={kind: np.array(rows) for kind, rows in cells.items()},
                     node_sets={"all": np.arange(len(nodes)), **more.pop("node_sets", {})}, **more)


@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize("kind, quadratic", itertools.product(CORNERS, (False, True)))
def test_outer_faces_enclose_the_cell(kind, quadratic, mirrored):
    """Area, and by the divergence theorem the volume, whose sign says that all faces look outwards."""
    surface = one_cell(kind, quadratic, mirrored).surface("all")
    assert surface.areas().sum() == pytest.approx(AREA[kind], rel=1e-12)
    volume, order = 0.0, {3: 3, 6: 3, 4: 4, 8: 4}
    for rows in surface.faces:
        assert rows.shape[1] in ((6, 8) if quadratic else (3, 4))
        X, k = surface.points[rows], rows.shape[1]
        centre = np.tile(faces.NODES[k][:order[k]].mean(axis=0), (len(X), 1))
        size = faces.node_areas(X).sum(axis=1)
        volume += np.einsum("fi,fi,f->", faces.normals(X, centre), X[:, :order[k]].mean(axis=1), size) / 3
        for corner in range(order[k] if quadratic else 0):  # mid-side nodes stand where they should
            following = (corner + 1) % order[k]
            np.testing.assert_allclose(X[:, order[k] + corner], (X[:, corner] + X[:, following]) / 2)
    assert volume == pytest.approx(VOLUME[kind], rel=1e-12)


def test_faces_between_cells_are_not_outer():
    structure = brick.pair(over=(3, 2, 2))
    assert structure.surface("over").areas().sum() == pytest.approx(2 * 2 + 2 * 2 + 2 * 1)
    upper = structure.surface("upper")
    assert upper.areas().sum() == pytest.approx(2) and len(upper.faces[0]) == 6
    np.testing.assert_allclose(upper.normals(), np.tile([0, 0, -1], (12, 1)), atol=1e-15)


def test_shells_are_surfaces_as_given():
    nodes = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], dtype=float)
    up, down = (structure_of(nodes, {"quad": [order]}).surface("all") for order in ([0, 1, 2, 3], [0, 3, 2, 1]))
    np.testing.assert_allclose(up.normals()[:, 2], 1)
    np.testing.assert_allclose(down.normals()[:, 2], -1)


def test_areas_of_single_faces():
    """Straight faces of area 2, corner and mid-side parts in closed form."""
    triangle = np.array([(0, 0, 0), (2, 0, 0), (0, 2, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], dtype=float)
    square = np.array([(0, 0, 0), (2, 0, 0), (2, 1, 0), (0, 1, 0), (1, 0, 0), (2, 0.5, 0), (1, 1, 0), (0, 0.5, 0)])
    for points, parts in ((triangle[:3], [1 / 3] * 3), (triangle, [1 / 12] * 3 + [1 / 4] * 3), (square[:4], [1 / 4] * 4),
                          (square, [1 / 24] * 4 + [5 / 24] * 4)):
        k = len(points)
        surface = Surface(points, np.arange(3 * k).reshape(-1, 3), [np.arange(k)[None]])
        np.testing.assert_allclose(surface.areas(), 2 * np.array(parts), rtol=1e-14)


@pytest.mark.parametrize("k", [3, 4, 6, 8])
def test_shape_functions(k):
    np.testing.assert_allclose(faces.shape(k, faces.NODES[k])[0], np.eye(k), atol=1e-15)
    xi = np.random.default_rng(k).random((6, 2)) / 2
    values, slopes = faces.shape(k, xi)
    np.testing.assert_allclose(values.sum(axis=1), 1, rtol=1e-14)
    for axis, step in enumerate(1e-5 * np.eye(2)):
        difference = (faces.shape(k, xi + step)[0] - faces.shape(k, xi - step)[0]) / 2e-5
        np.testing.assert_allclose(slopes[:, :, axis], difference, atol=1e-9)


def tube(kind, n):
    """A quarter of a tube of radius 1 and length 1 about y in n x n faces, looking outwards."""
    plane = lattice((n, n), kind, lambda x, y: 0 * x, edges=(np.pi / 2, 1.0))
    angle, y, _ = plane.points.T
    return Surface(np.stack([np.sin(angle), y, np.cos(angle)], axis=1), plane.dofs, plane.faces), angle


@pytest.mark.parametrize("kind", [3, 4, 6, 8])
def test_normals_and_area_of_a_tube(kind):
    """Away from the edges, where faces lie on all sides of a node, the averaged normals are of second order or better."""
    errors = []
    for n in (4, 8):
        surface, angle = tube(kind, n)
        inner = (angle > 0.01) & (angle < np.pi / 2 - 0.01) & (np.abs(surface.points[:, 1] - 0.5) < 0.49)
        errors.append([np.abs(surface.normals() - surface.points * [1, 0, 1])[inner].max(), abs(surface.areas().sum() - np.pi / 2)])
    assert errors[1][0] < 1e-12 or errors[1][0] < errors[0][0] / 3.2, errors
    assert errors[1][1] < errors[0][1] / 2.5 and errors[1][1] < 5e-3, errors


def test_clamping_removes_rows_columns_and_loads():
    structure = brick.pair().with_force("over", [1, 2, 3])
    clamped = structure.clamped("bottom").clamped("upper", "xz")
    gone = np.isin(structure.dof_node, structure.node_sets["bottom"])
    gone |= np.isin(structure.dof_node, structure.node_sets["upper"]) & (structure.dof_direction != 1)
    np.testing.assert_array_equal(clamped.K.toarray(), structure.K.toarray()[~gone][:, ~gone])
    np.testing.assert_array_equal(clamped.force, structure.force[~gone])
    np.testing.assert_array_equal(clamped.dof_node, structure.dof_node[~gone])
    assert structure.n == 162 and clamped.n == 162 - 27 - 18
    y = clamped.surface("upper").dofs
    assert np.all(y[:, [0, 2]] == -1) and np.all(clamped.dof_direction[y[:, 1]] == 1)
    rows = structure.node_sets["bottom"]
    np.testing.assert_array_equal(structure.clamped(rows).K.toarray(), structure.clamped(["bottom"]).K.toarray())


def test_rotations_go_with_all_three_directions():
    structure = Structure(sp.identity(7), sp.identity(7), [[0, 0, 0]], [0] * 6 + [-1], [0, 1, 2, 3, 4, 5, -1], node_sets={"a": [0]})
    np.testing.assert_array_equal(structure.clamped("a").dof_direction, [-1])
    np.testing.assert_array_equal(structure.clamped("a", "xy").dof_direction, [2, 3, 4, 5, -1])


def test_loads_are_totals():
    structure = brick.pair().with_force("top", [1, 2, 3]).with_force("top", [1, 0, 0]).with_preload(["top", "bottom"], [0, 0, 9])
    total = np.zeros(3)
    np.add.at(total, structure.dof_direction, structure.force)
    np.testing.assert_allclose(total, [2, 2, 3])
    assert structure.force[structure.dofs_of(structure.node_sets["top"])[4]] == pytest.approx([2 / 9, 2 / 9, 3 / 9])
    np.testing.assert_allclose(structure.preload[structure.dof_direction == 2].sum(), 9)
    held = brick.pair().clamped("top", "x")
    before, after = held.with_force("top", [5, 5, 5]), brick.pair().with_force("top", [5, 5, 5]).clamped("top", "x")
    np.testing.assert_array_equal(before.force, after.force)  # what falls on a clamped dof goes into the support


def test_named_surfaces_come_first():
    structure = brick.pair()
    face = structure.cells["hexahedron"][0][[0, 1, 5, 4]]
    given = Structure(structure.K, structure.M, structure.nodes, structure.dof_node, structure.dof_direction, cells=structure.cells,
                      node_sets=structure.node_sets, surfaces={"upper": [face[None]]}, labels=np.arange(54) + 1000)
    surface = given.surface("upper")
    assert len(surface.points) == 4 and surface.labels.min() >= 1000
    np.testing.assert_array_equal(surface.points[surface.faces[0][0]], structure.nodes[face])


def test_a_set_without_whole_faces_has_no_faces():
    structure = structure_of(brick.pair().nodes, {"hexahedron": brick.pair().cells["hexahedron"]}, node_sets={"line": [0, 1, 2]})
    line = structure.surface("line")
    assert line.faces == [] and len(line.points) == 3
    with pytest.raises(ValueError, match="surface 'line' has no faces, so its nodes have no area"):
        line.areas()


@pytest.mark.parametrize("make, message", [
    (lambda: brick.pair().surface("uper"), "no surface or node set 'uper'; did you mean 'upper'"),
    (lambda: brick.pair().clamped("xyz"), "no node set or surface 'xyz'; there are bottom, lower"),
    (lambda: brick.pair().clamped("top").clamped("top"), "nothing to clamp: the nodes of 'top' have no dofs in xyz"),
    (lambda: brick.pair().clamped([]), "nothing to clamp: the nodes of the 0 rows given"),
    (lambda: brick.pair().clamped("top", "w"), "directions must be some of x, y, z, found 'w'"),
    (lambda: brick.pair().clamped([54]), "node rows must be whole numbers from 0 to 53"),
    (lambda: brick.pair().with_force("top", [1, 2]), "force must be a vector of three finite numbers"),
    (lambda: brick.pair().clamped("top").with_preload("top", [0, 0, 1]), "no node of 'top' can take the preload"),
    (lambda: brick.pair().with_force([], [1, 0, 0]), "no node to put the force on: the 0 rows given is empty"),
    (lambda: Structure(sp.identity(3), sp.identity(3), [[0, 0]], [0] * 3, [0, 1, 2]), r"nodes must have shape \(n_nodes, 3\)"),
    (lambda: Structure(sp.identity(3), sp.identity(3), [[0, 0, np.nan]], [0] * 3, [0, 1, 2]), "nodes must have finite places, .* row 0"),
    (lambda: Structure(sp.identity(3), sp.identity(3), [[0, 0, 0]], [0, 0], [0, 1]), "dof_node must have one entry .* found shape"),
    (lambda: Structure(sp.identity(3), sp.identity(3), [[0, 0, 0]], [0] * 3, [0, 1, 6]), "dof_direction .* values 0 to 6"),
    (lambda: Structure(sp.identity(3), sp.identity(3), [[0, 0, 0]], [0] * 3, [0, 1, 2], node_sets={"a": [1]}), "node set 'a' must name"),
    (lambda: Structure(sp.identity(3), sp.identity(3), [[0, 0, 0]], [0] * 3, [0, 1, 2], force=[1]), "force must have one entry"),
])
def test_wrong_input_is_refused(make, message):
    with pytest.raises(ValueError, match=message):
        make()


def test_a_shell_that_coats_a_solid_hides_none_of_its_faces():
    nodes, cells = brick.grid((0, 0, 0), (1, 1, 1), (1, 1, 1))
    solid = {"hexahedron": cells}
    top = nodes[:, 2] == 1
    (bare,) = outer_faces(nodes, solid, top)
    (coated,) = outer_faces(nodes, {**solid, "quad": bare}, top)
    np.testing.assert_array_equal(coated, bare)
