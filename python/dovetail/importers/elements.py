"""Element types of CalculiX and Abaqus: which cell each is, and its faces in the numbering of *SURFACE."""

import re
from dataclasses import dataclass


@dataclass(frozen=True)
class Cell:
    """A shape. Node order is that of meshio and VTK, which CalculiX and Abaqus share for all shapes below."""

    name: str
    size: int  # nodes
    faces: dict  # face name -> nodes: corners counter-clockwise seen from outside, then mid-side nodes


TETRA = ("321", "124", "234", "143")
HEXAHEDRON = ("1432", "5678", "1265", "2376", "3487", "4158")
WEDGE = ("132", "456", "1254", "2365", "3146")
TETRA_EDGES = "12 23 31 14 24 34"
HEXAHEDRON_EDGES = "12 23 34 41 56 67 78 85 15 26 37 48"
WEDGE_EDGES = "12 23 31 45 56 64 14 25 36"


def _solid(name, corners, faces, edges=""):
    middle = {frozenset(edge): corners + k for k, edge in enumerate(edges.split())}
    table = {}
    for number, face in enumerate(faces, start=1):
        nodes = [int(corner) - 1 for corner in face]
        if middle:
            nodes += [middle[frozenset(pair)] for pair in zip(face, face[1:] + face[0])]
        table[f"S{number}"] = tuple(nodes)
    return Cell(name, corners + len(middle), table)


def _shell(name, corners, quadratic=False):
    front = tuple(range(corners))
    back = (0, *front[:0:-1])
    if quadratic:
        front, back = front + tuple(range(corners, 2 * corners)), back + tuple(range(2 * corners - 1, corners - 1, -1))
    return Cell(name, len(front), {"SPOS": front, "SNEG": back})


SOLIDS = {4: _solid("tetra", 4, TETRA), 10: _solid("tetra10", 4, TETRA, TETRA_EDGES),
          8: _solid("hexahedron", 8, HEXAHEDRON), 20: _solid("hexahedron20", 8, HEXAHEDRON, HEXAHEDRON_EDGES),
          6: _solid("wedge", 6, WEDGE), 15: _solid("wedge15", 6, WEDGE, WEDGE_EDGES)}
SHELLS = {3: _shell("triangle", 3), 6: _shell("triangle6", 3, True), 4: _shell("quad", 4), 8: _shell("quad8", 4, True)}
LINES = {2: Cell("line", 2, {}), 3: Cell("line3", 3, {})}
PATTERNS = ((re.compile(r"(?:C3D|SC|CSS)(4|6|8|10|15|20)(?!\d)[A-Z0-9]*"), SOLIDS),
            (re.compile(r"(?:S|M3D|STRI)(3|4|6|8)(?!\d)[A-Z0-9]*"), SHELLS),
            (re.compile(r"STRI6(5)"), {5: SHELLS[6]}), (re.compile(r"T3D(2|3)[A-Z]*"), LINES),
            (re.compile(r"B3(1|2|3)[A-Z]*"), {1: LINES[2], 2: LINES[3], 3: LINES[2]}))


def cell_of(element_type):
    """The Cell of an element type such as "C3D20R", or None for one that has no shape here (springs, masses, couplings)."""
    for pattern, cells in PATTERNS:
        found = pattern.fullmatch(element_type.upper())
        if found:
            return cells.get(int(found[1]))
    return None
