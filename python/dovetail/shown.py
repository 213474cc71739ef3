"""Which unknowns a picture or a list shows where none are named: the loaded node, the one watched, the contact point that moves."""

import h5py
import numpy as np

from .curves import is_reduced, moves_most
from .hdf5_read import members, numbers, opened
from .motion import find_model, node_row, read_model_parts
from .results import DIRECTIONS
from .units import with_unit

NEGLIGIBLE = 0.01  # a direction that moves less than this part of the largest one is left out
BEYOND = 1e-4  # of a value: how far past the ends one may be asked for, as printed ones are rounded
LOADED = 1e-6  # of the largest force: what counts as a force


def default_dofs(results):
    """The loaded node, where it can be known, then those of `contact_dofs`."""
    loaded = loaded_node(results)
    watched = [] if is_reduced(results.watched) else [results.watched]
    return list(dict.fromkeys([*([loaded] if loaded else []), *watched, *contact_dofs(results)]))


def contact_dofs(results):
    """The unknown that is watched, and the directions of its contact point, or of the one that moves most, without those that hardly
    move."""
    if results.contact_points == 0:
        return [results.watched] if is_reduced(results.watched) else ["a1"]
    size = np.sqrt(np.sum(results.coefficients[:, results.modes:, 1:] ** 2, axis=2)).max(axis=0, initial=0.0)
    first, names = [results.watched], results.dof_names()[results.modes:]
    if results.watched in names:
        j = names.index(results.watched) // 3
    else:
        j, first = moves_most(results.coefficients[:, results.modes:]) // 3, first if is_reduced(results.watched) else []
    moving = size[3 * j:3 * j + 3] > NEGLIGIBLE * size.max()
    found = [f"x{j + 1}.{d}" for d, moves in zip(DIRECTIONS, moving) if moves]
    return list(dict.fromkeys([*first, *found])) or [f"x{j + 1}.t1"]


def rubbing_dofs(results, point):
    """Tangential directions of the contact point that dissipates most at a point of the curve, unless the case watches another;
    without those that hardly move. Empty where there is no contact point."""
    count, names = results.contact_points, results.dof_names()[results.modes:]
    if count == 0:
        return []
    if results.watch in names:
        j = names.index(results.watch) // 3
    else:
        work = results.contact_activity(point).dissipation if results.has_activity else np.zeros(count)
        j = int(work.argmax()) if work.max() > 0 else moves_most(results.coefficients[:, results.modes:]) // 3
    rows = results.coefficients_at(point)[results.modes + 3 * j:results.modes + 3 * j + 2, 1:]
    size = np.sqrt(np.sum(rows ** 2, axis=1))
    return [f"x{j + 1}.{d}" for d, moves in zip(DIRECTIONS, size >= NEGLIGIBLE * size.max()) if moves]


def chosen_point(results, at=None, hz=False, dofs=None):
    """The point nearest to `at`, or, without it, where the first of the dofs has its peak, or is largest where it has none."""
    if at is not None:
        return results.at(value_at(results, at, hz))
    dof = (dofs or contact_dofs(results))[0]
    return results.peak_point(dof) if results.peaks(dof) else results.largest_point(dof)


def chosen_sectors(results, sector=None, wheel=False):
    """Numbers of the sectors that are meant; [0] of a structure that is none."""
    if results.wave is None and (wheel or sector is not None):
        raise ValueError(f"{results.path}: is not of a sector of a cyclic structure, so there is no "
                         + ("wheel" if wheel else f"sector {sector}"))
    if wheel and sector is not None:
        raise ValueError("--wheel is all sectors, --sector one of them; give one of the two")
    if wheel:
        return list(range(results.wave.sectors))
    return [0 if sector is None else results.wave.checked(sector)]


def value_at(results, at, hz):
    """The value of `along` that --at means: of a sweep over the frequency in Hz, if `hz`. ValueError where the curve has none such."""
    hertz = hz and results.parameter is None
    value, low, high = results.unit.from_hertz(at) if hertz else at, results.along.min(), results.along.max()
    rounding = BEYOND * max(abs(low), abs(high))
    if not low - rounding <= value <= high + rounding:
        what, unit = ("frequencies", results.unit.omega) if results.parameter is None else (results.parameter_name, results.along_unit)
        ends = (f"{results.unit.hertz(end) if hertz else end:.6g}" for end in (low, high))
        raise ValueError(f"--at {at:g}: {results.path} has {with_unit(f'{what} from ' + ' to '.join(ends), 'Hz' if hertz else unit)}")
    return value


def loaded_node(results):
    """Name of the node with the largest force in its direction, such as "tip.y": by the set of all loaded nodes, if there is one, else
    by its row. None where the model, its mesh or the motion of that node is not known."""
    try:
        path = find_model(results)
        mesh, _ = read_model_parts(path)
        force = _force(path)
        if mesh is None or len(force) != len(mesh["dof_node"]):
            return None
        force[mesh["changed"]["dof"]] = 0.0  # of relative motion, not of a node
        force[(mesh["dof_node"] < 0) | (mesh["dof_direction"] < 0) | (mesh["dof_direction"] > 2)] = 0.0
        if not force.any():
            return None
        largest = int(np.argmax(force))
        axis, node = mesh["dof_direction"][largest], mesh["dof_node"][largest]
        along = np.unique(mesh["dof_node"][(force > LOADED * force[largest]) & (mesh["dof_direction"] == axis)])
        names = [name for name, nodes in sorted(mesh["sets"].items()) if np.array_equal(np.unique(nodes), along)]
        name = f"{names[0] if names else node}.{'xyz'[axis]}"
        node_row(results, name)
        return name
    except (ValueError, OSError):
        return None


def _force(path):
    """(n,) largest size of the force at each dof, of all load patterns of a model file."""
    with opened(path) as file:
        names = [name for name in ("force", *(f"forces/{name}" for name in members(file, "forces"))) if name in file]
        loads = [np.abs(numbers(file, name)) for name in names if isinstance(file[name], h5py.Dataset)]
    return np.max(loads, axis=0) if loads else np.zeros(0)
