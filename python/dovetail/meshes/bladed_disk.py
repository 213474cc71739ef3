"""One of N equal sectors of a bladed disk: the blade of blade_root in its slot, the rim of the disk, and shrouds by choice. By gmsh.

x is the machine's axis, y points around it, z outwards. Left is the side at y < 0, and right is left turned by 360/N degrees about -x:
both sides of the disk carry the same triangles, and so do both contact faces of a shroud.
"""

from dataclasses import dataclass, field

import gmsh
import numpy as np

from ..cyclic import turn
from . import blade_root
from .tetrahedra import tetrahedra_of_gmsh

AXIS = (-1.0, 0.0, 0.0)  # about which right is left turned


@dataclass(frozen=True)
class Shroud:
    """A plate at the tip that reaches from one neighbour to the other. Dimensions [m]."""

    length: float = 0.026  # along the axis
    thickness: float = 0.004
    overlap: float = 0.003  # how far the airfoil reaches into it
    slope: float = -np.pi / 9  # of its contact faces to the axis: negative, a blade that untwists presses them on each other


@dataclass(frozen=True)
class BladedDisk(blade_root.Sector):
    """The dimensions of blade_root, and those of the shroud, None for none."""

    shroud: Shroud = field(default_factory=Shroud)

    @property
    def pitch(self):
        """Angle of a sector [rad]."""
        return 2 * np.pi / self.blades

    @property
    def shroud_radii(self):
        """Lower and upper radius of the contact faces [m]; the plate is flat, so it lies lower in the middle."""
        low = (super().tip - self.shroud.overlap) / np.cos(self.pitch / 2)
        return low, low + self.shroud.thickness

    @property
    def tip(self):
        """Radius where the airfoil ends [m]: below the shroud, if there is one."""
        return super().tip - (self.shroud.overlap + self.shroud.thickness if self.shroud else 0.0)

    def contact_face(self, side):
        """Corners (4, 3) of the contact face of the shroud at the left (-1) or right (1)."""
        half, (low, high) = self.shroud.length / 2, self.shroud_radii
        corners = np.array([(x, x * np.tan(self.shroud.slope), z) for x, z in ((-half, low), (half, low), (half, high), (-half, high))])
        return corners @ turn(AXIS, side * self.pitch / 2).T


def mesh_sector(dofs, flank_divisions=(3, 9), shroud_divisions=(1, 6), disk=BladedDisk(), side_divisions=None):
    """Mesh with about `dofs` unknowns, those of the bore not counted. Serial.

    Parameters
    ----------
    dofs : int
        Met within 5 %. The size of the elements follows from it, except on the contact faces.
    flank_divisions, shroud_divisions : (int, int)
        Pairs of triangles along the radius and along the axis.
    disk : BladedDisk
    side_divisions : (int, int), optional
        Likewise on both sides of the disk, whose nodes cost most in a reduction; default: elements of the size that follows from `dofs`.

    Returns
    -------
    dovetail.meshes.tetrahedra.Tetrahedra
        Node sets: `left`, `right` (sides of the disk); `bore`; `blade`, `disk`; `airfoil` (its pressure side), `tip` (corners of the
        outermost face); flanks of the root `flank_left`, `flank_right`, and of the slot `slot_left`, `slot_right`; contact faces of
        the shroud `shroud_left`, `shroud_right`.

    Raises
    ------
    ValueError
        When no size of the elements gives that number, or the dimensions do not go together.
    """
    divisions = [tuple(pair) for pair in (flank_divisions, shroud_divisions, side_divisions) if pair]
    if dofs < 1 or min(map(min, divisions)) < 1:
        raise ValueError(f"dofs and divisions must be positive, found {dofs}, {' and '.join(map(str, divisions))}")
    gmsh.initialize()
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("Mesh.MeshSizeExtendFromBoundary", 1)
        blade, solid = blade_root.bodies(disk, [(3, _plate(disk))] if disk.shroud else [])
        sets = {"blade": [(3, blade)], "disk": [(3, solid)], **_faces(disk, blade, solid), "tip": blade_root.tip_of(blade)}
        for name in ("flank_left", "flank_right", "slot_left", "slot_right"):
            blade_root.structured(sets[name][0][1], flank_divisions)
        for name in sorted({"shroud_left", "shroud_right"} & set(sets)):
            blade_root.structured(sets[name][0][1], shroud_divisions)
        for name in ("left", "right") if side_divisions else ():
            blade_root.structured(sets[name][0][1], side_divisions)
        matrix = np.eye(4)
        matrix[:3, :3] = turn(AXIS, disk.pitch)
        gmsh.model.mesh.setPeriodic(2, [sets["right"][0][1]], [sets["left"][0][1]], matrix.ravel().tolist())
        blade_root.sizes(disk)
        blade_root.mesh_of_size(dofs, sets["bore"])
        gmsh.model.mesh.setOrder(2)
        return tetrahedra_of_gmsh(sets).straightened()
    finally:
        gmsh.finalize()


def _plate(disk):
    """Tag of the shroud's volume, ruled from one contact face to the other."""
    occ, wires = gmsh.model.occ, []
    for side in (-1, 1):
        points = [occ.addPoint(*corner) for corner in disk.contact_face(side)]
        wires.append(occ.addWire([occ.addLine(a, b) for a, b in zip(points, points[1:] + points[:1])], checkClosed=True))
    plate = [tag for dimension, tag in occ.addThruSections(wires, makeSolid=True, makeRuled=True) if dimension == 3]
    occ.remove([(1, wire) for wire in wires], recursive=True)
    return plate[0]


def _faces(disk, blade, solid):
    """Surfaces (2, tag) that make the named node sets."""
    found = blade_root.faces(disk, blade, solid)
    for face in found.pop("clamped"):
        _, y, z = gmsh.model.occ.getCenterOfMass(*face)
        found["bore" if abs(z - disk.bottom) < 1e-6 else "left" if y < 0 else "right"] = [face]
    if disk.shroud:
        of_blade = gmsh.model.getBoundary([(3, blade)], oriented=False)
        for side, name in ((-1, "shroud_left"), (1, "shroud_right")):
            middle = disk.contact_face(side).mean(axis=0)
            found[name] = [face for face in of_blade if np.linalg.norm(gmsh.model.occ.getCenterOfMass(*face) - middle) < 1e-6]
    wanted = {"bore", "left", "right"} | ({"shroud_left", "shroud_right"} if disk.shroud else set())
    wrong = [name for name in sorted(wanted) if len(found.get(name, ())) != 1]
    if wrong:
        raise ValueError(f"the geometry has no such face as {wrong[0]} where it should be; are the dimensions sound?\n{disk}")
    return found
