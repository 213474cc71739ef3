"""Model files of cyclic sectors that are refused, in words that say what was found."""

import h5py
import numpy as np
import pytest

import cases
import sector_model
import launch
from sector_model import ALL, DOF, INNER, SECTOR


def refusal(folder, change, modes=8, interior=None, command="reduce", extra=""):
    sector_model.write_model(folder / "model.h5")
    with h5py.File(folder / "model.h5", "a") as file:
        change(file)
    case = sector_model.write_case(folder / "case.toml", modes, interior)
    case.write_text(extra + case.read_text())
    return launch.run(cases.Case(case, None, None, {}), command=command, status=2).err


def replaced(name, values):
    def change(file):
        del file[name]
        file[name] = values
    return change


def attribute(name, value):
    return lambda file: file["cyclic"].attrs.__setitem__(name, value)


LEFT, RIGHT = DOF[SECTOR["left"]], DOF[SECTOR["right"]]
NODES = np.concatenate([np.column_stack([SECTOR[f"{part}_a"], SECTOR[f"{part}_b"]]) for part in ("root", "shroud")])


def with_node(point, side, node):
    nodes = NODES.copy()
    nodes[point, side] = node
    return nodes


@pytest.mark.parametrize("change, words", [
    (attribute("sectors", 1), "sectors = 1; the number of sectors of the whole, at least 2"),
    (attribute("axis", [0.0, 0.0, 0.0]), "axis has no length"),
    (attribute("axis", [1.0, 0.0]), "axis must be three finite numbers"),
    (replaced("cyclic/left", LEFT[:-1]), "18 dofs where /cyclic/left has 15"),
    (replaced("cyclic/left", np.where(LEFT == LEFT[2, 1], 9999, LEFT)), "dof 9999 is out of range, 0..167 wanted"),
    (replaced("cyclic/right", np.where(RIGHT == RIGHT[2, 1], RIGHT[2, 0], RIGHT)), "is repeated"),
    (replaced("cyclic/right", RIGHT[:, [1, 0, 2]]), "are partners of different directions, 0 and 1"),
    (replaced("cyclic/right", np.where(RIGHT == RIGHT[1, 1], RIGHT[2, 1], np.where(RIGHT == RIGHT[2, 1], RIGHT[1, 1], RIGHT))),
     "has the partners"),
    (replaced("cyclic/right", np.where(RIGHT == RIGHT[1, 1], -1, RIGHT)), "has a partner that is held"),
    (replaced("cyclic/right", LEFT), "is in /cyclic/left, too"),
    (lambda file: (replaced("cyclic/left", np.delete(LEFT.ravel(), 4))(file), replaced("cyclic/right", np.delete(RIGHT.ravel(), 4))(file)),
     "is held in a direction that a turn about the axis does not keep"),
    (replaced("cyclic/next_sector", np.zeros(3, int)), "3 values, 8 wanted"),
    (replaced("cyclic/next_sector", np.full(8, 2)), "2 of contact point 0 (counted from 0); 0 or 1 is wanted"),
    (lambda file: file.__delitem__("cyclic/next_sector"), "/cyclic/next_sector: missing"),
    (lambda file: file.__delitem__("contact/nodes"), "/contact/nodes: missing"),
    (replaced("contact/nodes", with_node(0, 0, NODES[1, 0])), "is a contact node already; a node can be one only once"),
    (replaced("contact/nodes", with_node(0, 0, SECTOR["left"][0])), "is on the left or right face"),
    (replaced("contact/nodes", with_node(7, 1, SECTOR["clamped"][0])), "of contact point 7 (counted from 0) is clamped in some direction"),
    (replaced("contact/axes", np.ones((8, 3, 3))), "are not of length 1 and at right angles"),
    (lambda file: file.create_dataset("contact/dofs", data=[[0, 1, 2]]), "remove this dataset"),
    (lambda file: file.__delitem__("cyclic"), "/contact/dofs: missing"),
])
def test_a_wrong_sector_is_refused(tmp_path, change, words):
    assert words in refusal(tmp_path, change)


def test_a_node_that_is_no_contact_node_is_what_a_face_stands_on(tmp_path):
    def stands(node):
        def change(file):
            replaced("contact/nodes", with_node(0, 1, -1))(file)
            file["contact/faces/begin"], file["contact/faces/node"] = np.r_[0, np.ones(8, int)], [node]
            file["contact/faces/weight"] = [1.0]
        return change

    assert "stands on a node that is a contact node itself" in refusal(tmp_path, stands(NODES[1, 1]))
    assert "does not move" in refusal(tmp_path, stands(SECTOR["clamped"][0]))


def test_more_modes_than_there_are(tmp_path):
    assert f"the sector has only {INNER} dofs" in refusal(tmp_path, lambda file: None, 8, INNER + 1)
    assert f"make only {ALL} in each nodal diameter" in refusal(tmp_path, lambda file: None, ALL + 1, INNER)


def test_exact_modes_and_a_count_of_interior_ones(tmp_path):
    words = refusal(tmp_path, lambda file: None, extra="reduction.exact_modes = true\nreduction.check_modes = true\n")
    assert "reduction.check_modes counts interior modes" in words


def test_a_sector_that_nothing_holds(tmp_path):
    """Contacts held, clamps gone: the disk turns about its axis and moves along it at nodal diameter 0, across it at 1."""
    rows = np.arange(3 * sector_model.NODES)

    def free(file):
        for name in "KM":
            A = sector_model.sp.csr_matrix(tuple(SECTOR[f"{name}_{part}"] for part in ("data", "indices", "indptr"))).tocsc()
            for part, values in (("data", A.data), ("ir", A.indices), ("jc", A.indptr)):
                replaced(f"{name}/{part}", values)(file)
            file[name].attrs["MATLAB_sparse"] = A.shape[0]
        replaced("preload", SECTOR["preload"])(file), replaced("forces/lift", SECTOR["pattern_lift"])(file)
        replaced("mesh/dof_node", rows // 3)(file), replaced("mesh/dof_direction", rows % 3)(file)
        for side in ("left", "right"):
            replaced(f"cyclic/{side}", 3 * SECTOR[side][:, None] + np.arange(3))(file)

    words = refusal(tmp_path, free)
    assert "in motions of nodal diameter" in words and "can move without strain" in words


def test_interior_modes_of_a_model_that_is_no_sector(tmp_path):
    case = cases.several_points(tmp_path)
    case.edit("[reduction]\n", "[reduction]\ninterior_modes = 3\n")
    assert "is no sector of a cyclic structure, it has no /cyclic" in launch.run(case, command="reduce", status=2).err
