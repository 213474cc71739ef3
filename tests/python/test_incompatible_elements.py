"""C3D8I of CalculiX, whose elements have unknowns of their own inside: mass, unknowns and frequencies beside CalculiX itself."""

import numpy as np
import pytest
import scipy.sparse as sp
import scipy.sparse.linalg as sla

from brick_deck import DENSITY, deck, frequencies, run_ccx, solved
from dovetail.importers import calculix


def lowest(K, M):
    """The six lowest frequencies [rad/s]."""
    return np.sqrt(np.sort(sla.eigsh(sp.csc_matrix(K), 6, sp.csc_matrix(M), sigma=-1e6, return_eigenvectors=False)))


def written(path):
    """A matrix as CalculiX wrote it, of which it is one triangle."""
    row, column, value = np.loadtxt(path, unpack=True)
    one = sp.coo_matrix((value, (row.astype(int) - 1, column.astype(int) - 1)))
    return one + one.T - sp.diags(one.diagonal())


@pytest.mark.parametrize("held", [True, False])
def test_unknowns_inside_of_incompatible_elements_are_condensed(tmp_path, held):
    """The mass is that of the body, the unknowns are those of the nodes, statics are kept and low frequencies nearly."""
    shape = {"cells": (12, 3, 2)}
    text = deck(kind="C3D8I", **shape)
    text = text if held else text.replace("*BOUNDARY\nLEFT, 1, 3\n", "")
    structure = calculix.read([run_ccx(tmp_path, "bar", text)])
    assert (structure.dof_node >= 0).all()
    said = "\n".join(structure.notes)
    assert f"{9 * 72} unknowns inside of C3D8I elements are condensed" in said
    if not held:
        assert f"moving mass r^T M r: {40 * 10 * 5 * DENSITY:.6g} " in said and "nothing in the deck holds the mesh" in said
        return
    ours, theirs = lowest(structure.K, structure.M), frequencies(run_ccx(tmp_path, "modes", solved(text)))
    assert np.all(ours >= theirs * (1 - 1e-6))  # what moves statically only is stiffer
    np.testing.assert_allclose(ours, theirs, rtol=3.2e-3)


@pytest.mark.slow
def test_what_condensation_changes_falls_with_the_size_of_elements(tmp_path):
    """With the unknowns inside, frequencies are those of CalculiX. Without them they miss by the square of an element's size."""
    missed = []
    for name, cells in (("coarse", (12, 3, 2)), ("fine", (24, 6, 4))):
        text = deck(kind="C3D8I", cells=cells)
        path, theirs = run_ccx(tmp_path, name, text), frequencies(run_ccx(tmp_path, f"{name}_modes", solved(text)))
        np.testing.assert_allclose(lowest(*(written(path.with_suffix(end)) for end in (".sti", ".mas"))), theirs, rtol=1e-6)
        structure = calculix.read([path])
        missed.append((lowest(structure.K, structure.M) / theirs - 1).max())
    assert 0.2 < missed[1] / missed[0] < 0.3 and missed[1] < 9e-4
