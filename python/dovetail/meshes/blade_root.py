"""Sector of a bladed disk: a twisted blade with a dovetail root in the slot of its disk. Geometry, and ten-node tetrahedra by gmsh.

x is the machine's axis, y points around it, z outwards: the blade stands along z in the middle of the sector. All lengths in metres.
Root and slot share two flat inclined flanks, the right one at y > 0, and are apart everywhere else. Both sides of a flank carry the same
structured triangles, so that every node there has a partner at the same place.
"""

from dataclasses import dataclass

import gmsh
import numpy as np

from ..joint import Joint
from .rounded_outline import extrude_outline
from .tetrahedra import tetrahedra_of_gmsh, unknowns

AIRFOIL = (  # height above the platform [m], chord [m], angle of the chord to the axis [degree], camber and thickness in parts of the chord
    (0.0000, 0.046, 14.0, 0.120, 0.105),
    (0.0250, 0.044, 24.0, 0.100, 0.090),
    (0.0550, 0.041, 35.0, 0.080, 0.075),
    (0.0875, 0.038, 45.0, 0.062, 0.062),
    (0.1200, 0.035, 54.0, 0.048, 0.055),
)
EDGE = 0.0010  # thickness of leading and trailing edge
SECTION_POINTS = 9  # on either side of a section
TRIALS = 8  # meshes on the way to the wanted number of unknowns


@dataclass(frozen=True)
class Sector:
    """Dimensions [m]."""

    blades: int = 36  # so many sectors make the disk
    length: float = 0.050  # of root, platform and disk along the axis
    bottom: float = 0.250  # radius where the disk is cut off
    rim: float = 0.297
    platform: tuple = (0.300, 0.305)  # radii of its lower and upper face
    shank: float = 0.007  # half its thickness
    neck: float = 0.291  # radius where shank and flank would meet without rounding
    flank: float = 0.009  # straight part, in the plane across the axis
    slope: float = np.pi / 4  # of the flanks
    root_bottom: float = 0.277
    clearance: float = 0.0006  # between shank and slot, sides, bottoms
    concave: float = 0.004  # radius of the rounding between shank and flank
    convex: float = 0.002  # and between flank and side of the root
    chamfer: float = 0.002  # at the bottom of the root
    airfoil: tuple = AIRFOIL  # sections, from the platform up

    @property
    def tip(self):
        """Radius where the airfoil ends [m]."""
        return self.platform[1] + self.airfoil[-1][0]

    @property
    def flank_ends(self):
        """Upper and lower end (2, 2) of the right flank: y, z."""
        down = np.array([np.cos(self.slope), -np.sin(self.slope)])
        upper = np.array([self.shank, self.neck]) + self.concave * self._tangent * down
        return np.array([upper, upper + self.flank * down])

    @property
    def flank_area(self):
        """Of one flank [m^2]."""
        return self.flank * self.length

    @property
    def _tangent(self):
        """Distance from corner to start of a rounding of radius 1, where flank and upright lines meet."""
        return np.tan((np.pi / 2 - self.slope) / 2)

    def root_outline(self):
        """Corners (y, z, radius of rounding) of platform, shank and root: the right half, from top to bottom."""
        half_pitch = self.platform[0] * np.tan(np.pi / self.blades)
        y, z = self._corner(self.convex)
        return [(half_pitch - self.clearance, self.platform[1], 0), (half_pitch - self.clearance, self.platform[0], 0),
                (self.shank, self.platform[0], 0), (self.shank, self.neck, self.concave), (y, z, self.convex),
                (y, self.root_bottom + self.chamfer, 0), (y - self.chamfer, self.root_bottom, 0)]

    def disk_outline(self):
        """Likewise of the disk. Roundings at the flanks' ends are such that their straight parts are those of the root."""
        less = self.clearance / (np.cos(self.slope) * self._tangent)
        if less >= self.concave:
            raise ValueError(f"a clearance of {self.clearance:g} m needs a rounding between shank and flank of more than {less:.3g} m, "
                             f"found {self.concave:g} m")
        y, z = self._corner(self.convex + less)
        lip, bottom = self.shank + self.clearance, self.root_bottom - self.clearance
        chamfer = self.chamfer + (2 - np.sqrt(2)) * self.clearance  # also one clearance away
        side = np.tan(np.pi / self.blades)
        return [(side * self.bottom, self.bottom, 0), (side * self.rim, self.rim, 0), (lip, self.rim, 0),
                (lip, self.neck - self.clearance * np.tan(self.slope), self.concave - less), (y, z, self.convex + less),
                (y, bottom + chamfer, 0), (y - chamfer, bottom, 0)]

    def _corner(self, radius):
        """Where the flank's line ends (y, z) if a rounding of `radius` is to follow its straight part."""
        down = np.array([np.cos(self.slope), -np.sin(self.slope)])
        return self.flank_ends[1] + radius * self._tangent * down


def airfoil_section(chord, angle, camber, thickness):
    """Points (2, SECTION_POINTS, 2) of pressure and suction side: x, y, from leading to trailing edge, about the centroid.

    Camber line and thickness are parabolas; both edges are EDGE thick.
    """
    along = np.linspace(0.0, 1.0, SECTION_POINTS)
    arch = 4 * along * (1 - along)
    line = camber * chord * (arch - 2 / 3)
    half = 0.5 * (EDGE + (thickness * chord - EDGE) * arch)
    a = np.radians(angle)
    turn = np.array([[np.cos(a), np.sin(a)], [-np.sin(a), np.cos(a)]])
    return np.array([np.column_stack([chord * (along - 0.5), line + side * half]) @ turn for side in (-1, 1)])


def mesh_sector(dofs, flank_divisions=(3, 9), sector=Sector()):
    """Mesh with about `dofs` unknowns, clamped ones not counted. Serial.

    Parameters
    ----------
    dofs : int
        Met within 5 %. The size of the elements follows from it, except on the flanks.
    flank_divisions : (int, int)
        Pairs of triangles down a flank and along the axis.
    sector : Sector

    Returns
    -------
    dovetail.meshes.tetrahedra.Tetrahedra
        Node sets: `blade`, `disk`; `clamped` (bottom and sides of the disk); `airfoil` (its pressure side), `tip` (the corners of its
        outermost section); flanks of the root `flank_left`, `flank_right`, and of the disk `slot_left`, `slot_right`.

    Raises
    ------
    ValueError
        When no size of the elements gives that number, or the dimensions do not go together.
    """
    if dofs < 1 or min(flank_divisions) < 1:
        raise ValueError(f"dofs and divisions of the flanks must be positive, found {dofs} and {tuple(flank_divisions)}")
    gmsh.initialize()
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("Mesh.MeshSizeExtendFromBoundary", 1)
        blade, disk = bodies(sector)
        sets = {"blade": [(3, blade)], "disk": [(3, disk)], **faces(sector, blade, disk), "tip": tip_of(blade)}
        for name in ("flank_left", "flank_right", "slot_left", "slot_right"):
            structured(sets[name][0][1], flank_divisions)
        sizes(sector)
        mesh_of_size(dofs, sets["clamped"])
        gmsh.model.mesh.setOrder(2)
        return tetrahedra_of_gmsh(sets).straightened()
    finally:
        gmsh.finalize()


def flank_joints(solid, points=None, sector=Sector(), **contact):
    """Joints of both flanks of the root with the slot. t1 points down the flank, t2 along the axis.

    Parameters
    ----------
    solid : dovetail.Structure
        Of a mesh of this module, or of `bladed_disk`.
    points : (int, int), optional
        Contact points down a flank and along the axis, evenly spread; default all nodes.
    sector : Sector
    contact
        Stiffness per area [N/m^3] and friction, as in `Joint.between`.
    """
    (y0, z1), (y1, z0) = sector.flank_ends
    made = []
    for name, side in (("left", -1), ("right", 1)):
        at = None
        if points:
            down, along = (np.linspace(0, 1, n) if n > 1 else np.array([0.5]) for n in points)
            at = np.array([(sector.length * (a - 0.5), side * (y0 + d * (y1 - y0)), z1 + d * (z0 - z1)) for a in along for d in down])
        made.append(Joint.between(solid.surface(f"flank_{name}"), solid.surface(f"slot_{name}"), t1=(0, side * (y1 - y0), z0 - z1), at=at,
                                  name=name, **contact))
    return made


def bodies(sector, further=()):
    """Tags of the volumes of blade and disk; `further` solids (dimension, tag) become parts of the blade."""
    occ = gmsh.model.occ
    root = extrude_outline(sector.root_outline(), sector.length)
    disk = extrude_outline(sector.disk_outline(), sector.length)
    wires = []
    for height, *shape in sector.airfoil:
        pressure, suction = ([occ.addPoint(x, y, sector.platform[1] + height) for x, y in side] for side in airfoil_section(*shape))
        suction.reverse()
        curves = [occ.addSpline(pressure), occ.addLine(pressure[-1], suction[0]), occ.addSpline(suction),
                  occ.addLine(suction[-1], pressure[0])]
        wires.append(occ.addWire(curves, checkClosed=True))
    airfoil = [part for part in occ.addThruSections(wires, makeSolid=True) if part[0] == 3]
    occ.remove([(1, wire) for wire in wires], recursive=True)
    made, _ = occ.fuse([(3, root)], [*airfoil, *further])
    if len(made) != 1:
        raise ValueError(f"the blade would be {len(made)} pieces that do not touch; are the dimensions sound?\n{sector}")
    blade = made[0][1]
    occ.remove(occ.getEntities(0))  # points that only guided splines and arcs; the corners of bodies stay
    occ.synchronize()
    return blade, disk


def faces(sector, blade, disk):
    """Surfaces (2, tag) that make the named node sets, found by where they are."""
    found = {}
    for body, name in ((blade, "flank"), (disk, "slot")):
        faces = gmsh.model.getBoundary([(3, body)], oriented=False)
        (y0, z1), (y1, z0) = sector.flank_ends
        for side, (low, high) in {"left": (-y1, -y0), "right": (y0, y1)}.items():
            inside = gmsh.model.getEntitiesInBoundingBox(*_grown((-sector.length / 2, low, z0), (sector.length / 2, high, z1)), dim=2)
            found[f"{name}_{side}"] = sorted(set(inside) & set(faces))
    centre = {face: np.array(gmsh.model.occ.getCenterOfMass(*face)) for face in gmsh.model.getBoundary([(3, disk)], oriented=False)}
    middle = np.tan(np.pi / sector.blades) * (sector.bottom + sector.rim) / 2
    found["clamped"] = [face for face, (_, y, z) in centre.items() if abs(z - sector.bottom) < 1e-6 or abs(abs(y) - middle) < 1e-6]
    found["airfoil"] = [_pressure_side(sector, blade)]
    wanted = {"clamped": 3, "airfoil": 1, "flank_left": 1, "flank_right": 1, "slot_left": 1, "slot_right": 1}
    wrong = [name for name, count in wanted.items() if len(found[name]) != count]
    if wrong:
        raise ValueError(f"the geometry has no such face as {wrong[0]} where it should be; are the dimensions sound?\n{sector}")
    return found


def _pressure_side(sector, blade):
    """Of the faces that reach from platform to tip the one around the pressure side of the middle section."""
    height, *shape = sector.airfoil[len(sector.airfoil) // 2]
    place = np.array([*airfoil_section(*shape)[0, SECTION_POINTS // 2], sector.platform[1] + height])
    tall = []
    for face in gmsh.model.getBoundary([(3, blade)], oriented=False):
        _, _, low, _, _, high = gmsh.model.getBoundingBox(*face)
        if low < sector.platform[1] + 1e-3 and high > sector.tip - 1e-6:
            tall.append(face)
    return min(tall, key=lambda face: np.linalg.norm(gmsh.model.getClosestPoint(*face, place)[0] - place))


def tip_of(blade):
    """Corner points of the airfoil's end face."""
    end = max(gmsh.model.getBoundary([(3, blade)], oriented=False), key=lambda face: gmsh.model.getBoundingBox(*face)[2])
    return gmsh.model.getBoundary([end], oriented=False, recursive=True)


def _grown(low, high, by=1e-5):
    return *(np.array(low) - by), *(np.array(high) + by)


def structured(face, divisions):
    """Transfinite triangles whose diagonals do not depend on how the face came to be: corners given in a fixed order."""
    for _, edge in gmsh.model.getBoundary([(2, face)], oriented=False):
        x_min, _, _, x_max, _, _ = gmsh.model.getBoundingBox(1, edge)
        along_axis = x_max - x_min > 1e-3
        gmsh.model.mesh.setTransfiniteCurve(edge, divisions[1 if along_axis else 0] + 1)
    corners = [tag for _, tag in gmsh.model.getBoundary([(2, face)], recursive=True)]
    where = {tag: gmsh.model.getValue(0, tag, []) for tag in corners}
    low, high = (sorted(row, key=lambda tag: where[tag][0]) for row in np.split(
        np.array(sorted(corners, key=lambda tag: where[tag][2])), 2))
    gmsh.model.mesh.setTransfiniteSurface(face, "Left", [low[0], low[1], high[1], high[0]])


def sizes(sector):
    """Relative sizes of elements [m]: fine airfoil and root, coarse disk; `mesh_of_size` multiplies them."""
    for point in gmsh.model.getEntities(0):
        radius = gmsh.model.getValue(*point, [])[2]
        far = np.clip((sector.root_bottom - radius) / (sector.root_bottom - sector.bottom), 0, 1)
        gmsh.model.mesh.setSize([point], 0.003 + 0.006 * far)


def mesh_of_size(dofs, clamped):
    """Linear tetrahedra that have about `dofs` unknowns when made quadratic."""
    factor, tried = (90e3 / dofs) ** 0.45, []  # where the first mesh is about right
    for _ in range(TRIALS):
        gmsh.option.setNumber("Mesh.MeshSizeFactor", factor)
        gmsh.model.mesh.clear()
        gmsh.model.mesh.generate(3)
        found = unknowns([tag for _, tag in clamped])
        if abs(found / dofs - 1) < 0.05:
            return
        if tried and abs(np.log(found) - tried[-1][1]) < 0.01:
            break
        tried.append((np.log(factor), np.log(found)))
        factor = np.exp(_next_size(tried, np.log(dofs)))
    raise ValueError(f"no size of elements gives about {dofs} dofs: trials ended with {found}; the smallest possible mesh depends on "
                     "the divisions of the flanks")


def _next_size(tried, wanted):
    """Logarithm of the next factor: the line through the two trials nearest to `wanted`, or a guess of its slope."""
    tried = sorted(tried, key=lambda trial: abs(trial[1] - wanted))
    (x, y), slope = tried[0], -2.5
    if len(tried) > 1 and tried[1][0] != x:
        slope = np.clip((tried[1][1] - y) / (tried[1][0] - x), -4.0, -1.0)
    return x + (wanted - y) / slope
