"""Parts of a model one by one: what is refused, in which words, and what lies at the edge and is taken."""

import numpy as np
import pytest
import scipy.sparse as sp
from test_model import JOINT, MESH, cyclic, small

from dovetail import Model
from dovetail.model_cyclic import checked_cyclic

BLOCKS = {"Kee": np.eye(2), "Kec": np.ones((2, 3)), "Kcc": 5 * np.eye(3), "Mee": np.eye(2), "Mec": np.zeros((2, 3)), "Mcc": np.eye(3)}
ONE_CHANGE = {"dof": [1], "begin": [0, 1], "column": [2], "value": [1.0]}


@pytest.mark.parametrize("name, shape", [("Kee", "(2, 2)"), ("Kcc", "(3, 3)"), ("Mee", "(2, 2)"), ("Mec", "(2, 3)"), ("Mcc", "(3, 3)")])
def test_each_block_has_its_shape(name, shape):
    with pytest.raises(ValueError) as found:
        Model.from_blocks(**BLOCKS | {name: np.ones((4, 5))})
    assert str(found.value) == f"{name} must have shape {shape} to go with Kec of shape (2, 3), found (4, 5)"


@pytest.mark.parametrize("name, size", [("Fe", 2), ("Fc", 3), ("Pe", 2), ("Pc", 3)])
def test_each_part_of_a_load_has_its_size(name, size):
    with pytest.raises(ValueError, match=f"{name} must have {size} entries, found 4"):
        Model.from_blocks(**BLOCKS, **{name: np.ones(4)})
    taken = Model.from_blocks(**BLOCKS, **{name: np.ones(size)})
    load = taken.force if name[0] == "F" else taken.preload
    assert load.tolist() == ([1, 1, 0, 0, 0] if name[1] == "e" else [0, 0, 1, 1, 1])


def test_blocks_without_a_contact_point():
    none = BLOCKS | {"Kec": np.zeros((2, 0)), "Mec": np.zeros((2, 0)), "Kcc": np.zeros((0, 0)), "Mcc": np.zeros((0, 0))}
    with pytest.raises(ValueError, match=r"Kec must have 3 columns \(t1, t2, n\) per contact point, found 0"):
        Model.from_blocks(**none)


def test_other_parts_leave_the_first_model_as_it_is():
    first = small(contact={"gap": 1.0})
    other = first.with_contact({"friction": 0.5}).with_damping_matrix(3 * first.K).with_structural_matrix(first.K)
    assert other.contact["friction"].tolist() == [[0.5, 0.5]] and list(other.contact) == ["friction"] and list(first.contact) == ["gap"]
    assert (other.C != 3 * first.K).nnz == 0 and other.K_structural is first.K and first.C is first.K_structural is None
    assert other.with_damping_matrix(None).C is None and list(other.with_damping_matrix(None)._rows) == ["K", "M", "K_structural"]
    for change, message in ((first.with_stiffness, "M and K"), (first.with_damping_matrix, "K and C"),
                            (first.with_structural_matrix, "K and K_structural")):
        with pytest.raises(ValueError, match=f"{message} must have the same size, found 9 and 8"):
            change(sp.identity(8))


def test_edges_are_taken():
    assert small(contact_dofs=[[0, 4, 8]]).contact_dofs.tolist() == [[0, 4, 8]]
    mesh = {**MESH, "dof_node": [0, -1, *[0] * 7], "dof_direction": [5, -1, *[0] * 7], "sets": {"none": [], "one": [0]},
            "cells": {"vertex": [[0]], "line": np.empty((0, 2), int)},
            "changed": {"dof": [0, 8], "begin": [0, 0, 2], "column": [0, 8], "value": [1.0, 2.0]}}
    taken = small(mesh=mesh, joint={**JOINT, "joint": [1], "names": ["a", "b"]})
    assert taken.mesh["dof_node"].tolist()[:2] == [0, -1] and taken.mesh["changed"]["begin"].tolist() == [0, 0, 2]
    assert taken.mesh["cells"]["line"].shape == (0, 2) and taken.joint["joint"].tolist() == [1]
    held = cyclic(sectors=2, left=[[-1] * 3], right=[[-1] * 3], next_sector=[1, 1], axis=[0.6, 0, 0.8], faces=None)
    assert cyclic(axis=[0, 0, 1 + 1e-14])["axis"][2] == 1 + 1e-14  # a unit vector but for rounding errors
    assert held["sectors"] == 2 and held["left"].tolist() == [[-1, -1, -1]] and held["next_sector"].tolist() == [1, 1]
    edge = cyclic(left=[[0, 1, 2], [3, -1, -1]], right=[[8, 7, 6], [5, -1, -1]], nodes=[[0, -1], [-1, 2]],
                  faces={"begin": [0, 0, 2], "node": [0, 2], "weight": [0.5, 0.5]})
    assert edge["right"][0].tolist() == [8, 7, 6] and edge["faces"]["node"].tolist() == [0, 2]
    assert cyclic(left=edge["right"], right=edge["left"])["right"].tolist() == edge["left"].tolist()  # the first dof on either side


@pytest.mark.parametrize("changes, message", [
    ({"contact_dofs": [[0, 1]]}, r"found int64 of shape \(1, 2\)"),
    ({"mesh": {**MESH, "nodes": np.zeros(3)}}, r"mesh nodes must have shape \(n_nodes, 3\), found \(3,\)"),
    ({"mesh": {**MESH, "more": 1}}, "mesh must have nodes, cells, dof_node, dof_direction and may have .* found .*more"),
    ({"mesh": {**MESH, "cells": {"line": [[0, -1]]}}}, "mesh cells 'line' must be .* numbers of nodes, 0 to 0"),
    ({"mesh": {**MESH, "sets": {"tip": [0, -1]}}}, "mesh set 'tip' must hold numbers of nodes, 0 to 0"),
    ({"mesh": {**MESH, "cells": {"line": [0, 0]}}}, r"mesh cells 'line' must be \(n_cells, nodes per cell\)"),
    ({"mesh": {**MESH, "dof_node": np.zeros(8, int)}}, r"mesh dof_node must have shape \(9,\) and values from -1 to 0, found shape \(8,\)"),
    ({"mesh": {**MESH, "dof_node": np.full(9, -2)}}, "mesh dof_node must have shape"),
    ({"mesh": {**MESH, "dof_node": np.full(9, 1)}}, "mesh dof_node must have shape"),
    ({"mesh": {**MESH, "dof_direction": np.full(9, -2)}}, "mesh dof_direction must have shape"),
    ({"mesh": {**MESH, "changed": {"dof": []}}}, "mesh changed must have dof, begin, column, value, found dof"),
    *(({"mesh": {**MESH, "changed": ONE_CHANGE | change}}, "mesh changed must give, for each of its dofs, columns 0 to 8") for change in (
        {"begin": [0, 1, 1]}, {"begin": [1, 1]}, {"begin": [0, 0]}, {"dof": [9]}, {"dof": [-1]}, {"column": [-1]}, {"value": []},
        {"dof": [1, 2], "begin": [0, 2, 1]}, {"dof": [1, 2, 3], "begin": [0, 2, 1, 1]})),
    ({"joint": {**JOINT, "more": 1}}, "joint must have position, axes, area, joint, names, found .*more"),
])
def test_wrong_parts_are_refused(changes, message):
    with pytest.raises(ValueError, match=message):
        small(**changes)


@pytest.mark.parametrize("changes, message", [
    *(({"sectors": value}, "cyclic sectors must be a whole number from 2 on") for value in (2.5, np.inf, np.nan, "3", [3], 0)),
    *(({"axis": value}, "cyclic axis must be a unit vector") for value in ([0, 0, 1 + 1e-9], [0, 1], [0, 0, np.nan], [0, 0, 0])),
    *(({"origin": value}, r"and origin a point \(3,\)") for value in ([0, 0], [0, 0, np.inf])),
    ({"left": [[0, 1, -1]]}, r"found shapes \(1, 3\) and \(2, 3\)"),
    ({"left": [0, 1, 2], "right": [3, 4, 5]}, r"found shapes \(3,\) and \(3,\)"),
    ({"left": [[0, 1, 6], [4, -1, -1]]}, "held on both sides alike"),
    ({"left": [[0, 2, -1], [4, -1, -1]]}, "cyclic left and right must be dofs 0 to 8, each once"),
    ({"nodes": np.empty((0, 2), int), "next_sector": []}, r"cyclic nodes must be \(N_x, 2\) node rows up to 2, .* found shape \(0, 2\)"),
    ({"nodes": [[0, 1], [0, -1]]}, "each contact node once, found node row 0 2 times"),
    ({"nodes": [[0, 1, 2], [-1, -1, -1]]}, r"found shape \(2, 3\)"),
    ({"next_sector": [0]}, r"cyclic next_sector must be 0 or 1 for each of 2 contact points, found shape \(1,\)"),
    ({"next_sector": [0, -1]}, "cyclic next_sector must be 0 or 1"),
    ({"more": 1}, "cyclic must have sectors, axis, origin, left, right, next_sector, nodes and may have faces; found .*more"),
    ({"faces": {"begin": [0, 1, 1]}}, "cyclic faces must have begin, node, weight, found begin"),
    *(({"faces": {"begin": [0, 1, 1], "node": [2], "weight": [1.0]} | change}, "cyclic faces must give, for each of 2 contact points")
      for change in ({"begin": [0, 1]}, {"begin": [1, 1, 1]}, {"begin": [0, 0, 0]}, {"node": [-1]}, {"weight": []}, {"node": [2, 1]},
                     {"begin": [0, 2, 1], "node": [1, 2][:1]})),
])
def test_wrong_sectors_are_refused(changes, message):
    with pytest.raises(ValueError, match=message):
        cyclic(**changes)


def test_a_sector_needs_all_of_its_keys_and_an_unchanged_mesh():
    mesh = {"nodes": np.zeros((3, 3)), "changed": {"dof": np.empty(0)}}
    whole = {key: value for key, value in cyclic().items()}
    for key in set(whole) - {"faces"}:
        with pytest.raises(ValueError, match="cyclic must have sectors, axis"):
            checked_cyclic({name: value for name, value in whole.items() if name != key}, 9, mesh, {})
    with pytest.raises(ValueError, match="before joints change its unknowns, found mesh changed"):
        checked_cyclic(whole, 9, {**mesh, "changed": {"dof": np.zeros(1)}}, {})
    for parts in ((None, {}), (mesh, None)):
        with pytest.raises(ValueError, match="a cyclic model needs mesh and joint"):
            checked_cyclic(whole, 9, *parts)
