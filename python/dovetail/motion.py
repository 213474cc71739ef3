"""Motion of the nodes of the full model, from results, the reduced file and the mesh of the model file."""

from pathlib import Path

import h5py
import numpy as np
import scipy.sparse as sp

from . import model_mesh
from .checked import whole_numbers
from .curves import is_reduced
from .cyclic import turn
from .hdf5_read import opened, words
from .model_cyclic import read_cyclic
from .recovery import reduced_file, rows


def find_model(results, given=None):
    """The model file a run started from: `given`, or that of `results`, or the one the reduced file names, also near the results.

    Raises ValueError when there is none.
    """
    given = results.model if given is None else given
    if given is not None:
        candidates = [Path(given)]
    else:
        name = Path(_model_named(results))
        folder = results.path.resolve().parent
        candidates = [name, folder / name, folder / name.name, folder.parent / name.name]
    for path in candidates:
        if h5py.is_hdf5(path):
            return path
    raise ValueError(f"the model file of {results.path} is not there ({candidates[0]}); name it with --model")


def _model_named(results):
    try:
        path = reduced_file(results)
    except ValueError as error:
        raise ValueError(f"{error}, so the model file is not known; name it with --model") from None
    with opened(path) as file:
        name = words(file, "model")
    if not name:
        raise ValueError(f"{path}: does not say which model it was made from; name the model file with --model")
    return name


def read_model_parts(path):
    """(mesh, joint) of a model file, as in `Model`, without its matrices; None where there is none."""
    with opened(path) as file:
        kind = words(file, "format", "unnamed")
        if kind != "dovetail-model":
            raise ValueError(f"{path}: format must be dovetail-model, found {kind}")
        return model_mesh.read_mesh(file), model_mesh.read_joint(file)


class PlacesUnknown(ValueError):
    """The model does not say where its contact points are."""


def find_joint(results, model=None):
    """Places of the contact points of results, as `joint` in `Model`, from `find_model`. Raises PlacesUnknown where they are not known,
    another ValueError where the model is not that of the results."""
    path = find_model(results, model)
    _, joint = read_model_parts(path)
    if joint is None:
        raise PlacesUnknown(f"{path}: has no /contact/position, so the places of its contact points are not known; models made by "
                         "Structure.join have them")
    if len(joint["position"]) != results.contact_points:
        raise ValueError(f"{path}: has {len(joint['position'])} contact points, the results have {results.contact_points}; name the "
                         "model of this run with --model")
    return joint


def nodal_displacement(results, point, nodes=None, n=64, times=None, model=None, sector=None, axes="sector"):
    """Total displacement of nodes, preload included, x_e0 + Phi a + Psi x and u = T q.

    Parameters
    ----------
    results : Results
    point : int
    nodes : (k,) int array or name of a set, optional
        Rows of the mesh's nodes; default all.
    n : int
        Equal steps over one period ...
    times : (N,) array, optional
        ... or these times [s].
    model : path-like, optional
        Default: `find_model`.
    sector : int, optional
        Of a cyclic structure; default 0.
    axes : str
        "sector": x, y, z turned along with the sector, as those of all sectors look alike in; "global": those of the model.

    Returns
    -------
    (N, k, 3) array [m]; zero where a direction is clamped.
    """
    if axes not in ("sector", "global"):
        raise ValueError(f'axes must be "sector" or "global", found {axes!r}')
    path = find_model(results, model)
    mesh, _ = read_model_parts(path)
    if mesh is None:
        raise ValueError(f"{path}: has no mesh, so its nodes are not known")
    if isinstance(nodes, str):
        if nodes not in mesh["sets"]:
            raise ValueError(f"{path}: no set {nodes!r}; there are {', '.join(sorted(mesh['sets'])) or 'none'}")
        nodes = mesh["sets"][nodes]
    nodes = np.arange(len(mesh["nodes"])) if nodes is None else whole_numbers(nodes, "nodes", 0, len(mesh["nodes"]) - 1)
    nodes, again = np.unique(nodes, return_inverse=True)
    place = np.full(len(mesh["nodes"]), -1)
    place[nodes] = np.arange(len(nodes))
    node, direction = mesh["dof_node"], mesh["dof_direction"]
    wanted = np.flatnonzero((node >= 0) & (place[node] >= 0) & (direction >= 0) & (direction < 3))
    T = _rows_of_T(mesh, wanted)
    columns, compact = np.unique(T.indices, return_inverse=True)
    T = sp.csr_matrix((T.data, compact, T.indptr), shape=(len(wanted), len(columns)))
    u = (T @ results.unknowns(point, columns, n, times, sector).T).T
    field = np.zeros((len(u), len(nodes), 3))
    field[:, place[node[wanted]], direction[wanted]] = u
    if axes == "global" and sector:
        field = field @ _turn_to(results, path, sector).T
    return field[:, again]


def _turn_to(results, path, sector):
    """(3, 3) turn from sector 0 to another."""
    with opened(path) as file:
        cyclic = read_cyclic(file)
    if cyclic is None or cyclic["sectors"] != results.wave.sectors:
        found = "no sector of a cyclic structure" if cyclic is None else f"one of {cyclic['sectors']} sectors"
        raise ValueError(f"{path}: is {found}, the results are of one of {results.wave.sectors}; name the model of this run")
    return turn(cyclic["axis"], 2 * np.pi * sector / results.wave.sectors)


def node_row(results, name, h=0):
    """The motion of a node or node set by the unknowns of `coefficients`, (N_a + 3 N_x,): "tip.y" or "17.z".

    Of a set with several nodes it is the mean; a node that is held in the direction counts as zero. In a sector of a cyclic
    structure the row is that of a spatial index h, complex unless h = 0.
    """
    dofs, parts = _dofs_of_node(results, name)
    return parts @ rows(results, dofs, h)


def _dofs_of_node(results, name):
    """Dofs (k,) of the model whose motion that of a node or node set is made of, and their parts (k,) in it."""
    path = find_model(results)
    mesh, _ = read_model_parts(path)
    if mesh is None:
        raise ValueError(f"{path}: has no mesh, so the node of {name!r} is not known")
    where, axis = name.rsplit(".", 1)
    if where in mesh["sets"]:
        nodes = np.unique(mesh["sets"][where])
    elif where.isdecimal() and int(where) < len(mesh["nodes"]):
        nodes = np.array([int(where)])
    else:
        raise ValueError(f"{path}: no node or node set {where!r}, as in {name!r}; there are nodes 0 to {len(mesh['nodes']) - 1}, and sets "
                         f"{', '.join(sorted(mesh['sets'])) or 'none'}")
    wanted = np.flatnonzero(np.isin(mesh["dof_node"], nodes) & (mesh["dof_direction"] == "xyz".index(axis)))
    if not wanted.size:
        raise ValueError(f"{path}: {where} does not move along {axis}: it is held there, or has no such degree of freedom")
    mean = np.asarray(_rows_of_T(mesh, wanted).sum(axis=0)).ravel() / len(nodes)
    dofs = np.flatnonzero(mean)
    return dofs, mean[dofs]


def node_rows_by_harmonic(results, name):
    """The `node_row` of every harmonic of a sector of a cyclic structure, (H+1, N_a + 3 N_x), for complex amplitudes."""
    dofs, parts = _dofs_of_node(results, name)
    found = {h: parts @ rows(results, dofs, h) for h in np.unique(results.wave.index)}
    return np.array([found[h] for h in results.wave.index])


def row_of(results, dof):
    """What a name as in `Results` is of the unknowns: its row, or that of `node_row`."""
    if is_reduced(dof):
        return results.dof_index(dof)
    return node_row(results, dof) if results.wave is None else node_rows_by_harmonic(results, dof)


def _rows_of_T(mesh, dofs):
    """Rows (k, n) of T for some dofs: the unknown itself, or what `changed` says."""
    n = len(mesh["dof_node"])
    changed = mesh.get("changed")
    if changed is None:
        changed = {"dof": np.empty(0, int), "begin": np.zeros(1, int), "column": np.empty(0, int), "value": np.empty(0)}
    block = sp.csr_matrix((changed["value"], changed["column"], changed["begin"]), shape=(len(changed["dof"]), n))
    number = np.full(n, -1)
    number[changed["dof"]] = np.arange(len(changed["dof"]))
    new = number[dofs] >= 0
    plain, moved = np.flatnonzero(~new), np.flatnonzero(new)
    rows = sp.vstack([sp.csr_matrix((np.ones(len(plain)), (np.arange(len(plain)), dofs[plain])), shape=(len(plain), n)),
                      block[number[dofs[moved]]]]).tocsr()
    order = np.empty(len(dofs), dtype=np.int64)
    order[np.concatenate([plain, moved])] = np.arange(len(dofs))
    return rows[order]
