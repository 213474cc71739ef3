"""Materials of cells: what stresses are computed from."""

from dataclasses import dataclass

import numpy as np

from . import solids

UNKNOWN = -1  # in place of a material's number


@dataclass(frozen=True)
class Material:
    """Linear, isotropic."""

    young: float  # [Pa]
    poisson: float
    density: float = 0.0  # [kg/m^3], 0 if not known
    name: str = "material"

    def __post_init__(self):
        if not (np.isfinite(self.young) and self.young > 0 and -1 < self.poisson < 0.5 and np.isfinite(self.density) and self.density >= 0):
            raise ValueError(f"material {self.name!r} must have a positive Young's modulus, a Poisson's ratio between -1 and 0.5 and no "
                             f"negative density, found {self.young:g}, {self.poisson:g}, {self.density:g}")


def checked(mesh, cells):
    """`materials`, `material` and `integration` of a `mesh` of Model, for its cells: arrays for every kind of cell."""
    materials = [one if isinstance(one, Material) else Material(*one) for one in mesh.get("materials", ())]
    found = {"materials": materials}
    for key, most, usual in (("material", len(materials), UNKNOWN), ("integration", len(solids.INTEGRATION), solids.USUAL)):
        given = mesh.get(key, {})
        strange = sorted(set(given) - set(cells))
        if strange:
            raise ValueError(f"mesh {key} must be for kinds of cells that there are ({', '.join(sorted(cells)) or 'none'}), found "
                             f"{strange[0]}")
        found[key] = {kind: np.asarray(given.get(kind, np.full(len(rows), usual)), dtype=np.int64) for kind, rows in cells.items()}
        for kind, numbers in found[key].items():
            if numbers.shape != (len(cells[kind]),) or numbers.size and not usual <= numbers.min() <= numbers.max() < most:
                raise ValueError(f"mesh {key} of {kind} must have shape ({len(cells[kind])},) and values from {usual} to {most - 1}, found "
                                 f"shape {numbers.shape}")
    return found


def of_cells(material, cells, number, inside=None):
    """`material` with another number for cells all of whose nodes are marked (n_nodes, bool), or for all; and how many they are."""
    result, count = {}, 0
    for kind, rows in cells.items():
        mine = np.ones(len(rows), bool) if inside is None else inside[rows].all(axis=1)
        result[kind] = np.where(mine, number, material.get(kind, np.full(len(rows), UNKNOWN)))
        count += mine.sum()
    return result, int(count)
