"""The Brake-Reuss beam: two half beams that overlap in a lap joint, and three bolts. Geometry, and ten-node tetrahedra by gmsh.

           bolts  | | |
    ==============+-----+          z, along the bolts
    |     A       |  B  ======     |
    |       +-----+-----      |    +-- x, along the beam; y, across
    ========+-----+============
            <-lap->

The lap lies in the plane z = 0, A is below it. The ends of the laps stand at the steps of the other half without touching them.
"""

import gmsh
import numpy as np

from dovetail.meshes.tetrahedra import Tetrahedra, tetrahedra_of_gmsh

LENGTH, SECTION, LAP = 0.720, 0.0254, 0.120  # of the whole beam; its square; length of the joint [m]
PITCH, HOLE = 0.030, 0.0085  # of the three bolts; diameter of their holes [m]
SHANK = 0.0069  # diameter [m] of the stress area of a 5/16-24 thread, 37.4 mm^2
WASHER, WASHER_HEIGHT = 0.01746, 0.00159  # diameter [m]
HEAD, HEAD_HEIGHT = 0.01334, 0.00516  # of a disc with the area of a hexagon of 12.7 mm; the nut is the same [m]
BOLTS = (-PITCH, 0.0, PITCH)


def mesh(size, tied=False):
    """Both half beams and the bolts, which are tied to the outer faces.

    Parameters
    ----------
    size : float
        Edges on the lap [m]; three times as long at the ends of the beam.
    tied : bool
        Both halves share their nodes on the lap; else each has its own, at the same places.

    Returns
    -------
    dovetail.meshes.tetrahedra.Tetrahedra
        Node sets: `lap A`, `lap B` (not where tied); `head 1` to `nut 3`, ends of the shanks; `ends` of the beam; `tip`, the node in
        the middle of the end of B.
    """
    gmsh.initialize()
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        volumes = _volumes()
        _sizes(size)
        gmsh.model.mesh.generate(3)
        gmsh.model.mesh.setOrder(2)
        names = {"A": volumes[0], "B": volumes[1], **{f"bolt {i}": bolt for i, bolt in enumerate(volumes[2:], 1)}}
        whole = tetrahedra_of_gmsh({name: [(3, tag) for tag in tags] for name, tags in names.items()}).straightened()
    finally:
        gmsh.finalize()
    return _split(whole, tied)


def _volumes():
    """Tags of the volumes of A, B and each bolt. Where they touch they share a face."""
    occ, half = gmsh.model.occ, SECTION / 2
    outline = [(-LENGTH / 2, half), (-LAP / 2, half), (-LAP / 2, 0), (LAP / 2, 0), (LAP / 2, -half), (-LENGTH / 2, -half)]
    halves = []
    for turn in (1, -1):
        points = [occ.addPoint(turn * x, -half, turn * z) for x, z in outline]
        loop = occ.addCurveLoop([occ.addLine(*ends) for ends in zip(points, points[1:] + points[:1])])
        solid = next(part for part in occ.extrude([(2, occ.addPlaneSurface([loop]))], 0, SECTION, 0) if part[0] == 3)
        holes = [(3, occ.addCylinder(x, 0, -half, 0, 0, SECTION, HOLE / 2)) for x in BOLTS]
        halves.append(occ.cut([solid], holes)[0])
    bolts = []
    for x in BOLTS:
        shank = (3, occ.addCylinder(x, 0, -half, 0, 0, SECTION, SHANK / 2))
        caps = []
        for side in (1, -1):
            washer = (3, occ.addCylinder(x, 0, side * half, 0, 0, side * WASHER_HEIGHT, WASHER / 2))
            head = (3, occ.addCylinder(x, 0, side * (half + WASHER_HEIGHT), 0, 0, side * HEAD_HEIGHT, HEAD / 2))
            caps += occ.fuse([washer], [head])[0]
        bolts.append([shank, *caps])
    parts = [*halves, *bolts]
    _, pieces = occ.fragment([part for body in parts for part in body], [])
    occ.removeAllDuplicates()
    occ.synchronize()
    counts = np.cumsum([0] + [len(body) for body in parts])
    return [[tag for found in pieces[begin:end] for _, tag in found] for begin, end in zip(counts, counts[1:])]


def _sizes(size):
    """`size` [m] within the lap and its washers, three times as much at the ends; eight edges round a hole."""
    field = gmsh.model.mesh.field.add("MathEval")
    past = f"((Abs(x) - {LAP / 2}) + Abs(Abs(x) - {LAP / 2})) / 2"  # the lap
    gmsh.model.mesh.field.setString(field, "F", f"{size} * (1 + 2 * ({past}) / {(LENGTH - LAP) / 2})")
    gmsh.model.mesh.field.setAsBackgroundMesh(field)
    gmsh.option.setNumber("Mesh.MeshSizeExtendFromBoundary", 0)
    gmsh.option.setNumber("Mesh.MeshSizeFromPoints", 0)
    gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", 8)


def _split(whole, tied):
    """With nodes of its own for B where it touches A, but for those on a lap that is tied."""
    nodes, sets = whole.nodes, whole.node_sets
    shared = np.intersect1d(sets["A"], sets["B"])
    lap = shared[np.abs(nodes[shared, 2]) < 1e-9]
    copied = np.setdiff1d(shared, lap) if tied else shared
    row = np.arange(len(nodes))
    row[copied] = len(nodes) + np.arange(len(copied))
    cells = whole.cells.copy()
    x, _, z = nodes[cells[:, :4]].mean(axis=1).T
    of_B = np.where(z > 0, x > -LAP / 2, x > LAP / 2)  # bolts have none of the nodes that are copied
    cells[of_B] = row[cells[of_B]]
    nodes = np.vstack([nodes, nodes[copied]])
    x, _, z = nodes.T
    used = np.isin(np.arange(len(nodes)), cells)
    found = {"ends": np.flatnonzero(used & (np.abs(np.abs(x) - LENGTH / 2) < 1e-9)),
             "tip": [np.argmin(np.linalg.norm(nodes - [LENGTH / 2, 0, 0], axis=1))]}
    for i, place in enumerate(BOLTS, 1):
        bolt = np.zeros(len(nodes), dtype=bool)
        bolt[sets[f"bolt {i}"]] = True
        shank = bolt & (np.hypot(x - place, nodes[:, 1]) < SHANK / 2 + 1e-6)
        for end, level in (("head", SECTION / 2), ("nut", -SECTION / 2)):
            found[f"{end} {i}"] = np.flatnonzero(shank & (np.abs(z - level) < 1e-9))
    if not tied:
        found |= {"lap A": lap, "lap B": row[lap]}
    return Tetrahedra(nodes, cells, found)
