"""Models of a sector, as Structure writes them, reduced by the program: modes and stiffness of every nodal diameter against NumPy."""

import h5py
import numpy as np
import pytest
from ring import N, sector

from dovetail import Joint, Model
from dovetail.reference import sector_basis, sector_frequencies
from launch import BINARY, words_of

MODES = 8
CASE = f"""model = "model.h5"
reduction = {{ modes = {MODES}, exact_modes = true }}
damping.stiffness = 1e-3
excitation = {{ fourier = [0, 1], engine_order = 1 }}
harmonic_balance.harmonics = 1
continuation.omega = [1.0, 2.0]
stability.enabled = false
"""
STIFF = {"normal_stiffness": 1e3, "tangential_stiffness": 5e2, "friction": 0.3}
HELD = {"everything": [], "a": [("over_right", "xyz")], "b": [("over_left", "xyz")], "a face in part": [("outer", "z")],
        "the bore along the axis": [("bore", "z")], "the bore": [("bore", "xyz")]}


@pytest.mark.parametrize("held, shift", [(held, shift) for shift in (0.0, 0.3) for held in HELD
                                         if (held, shift) not in (("a", 0.3), ("a face in part", 0.0))])  # which joints refuse
def test_the_program_reads_every_kind_of_contact(tmp_path, held, shift):
    """On springs at the bore or clamped there, so that nothing spins or flies away with its contact points held."""
    structure = sector(shift=shift).with_springs("bore", [50, 50, 50])
    left = structure.node_sets["over_left"]
    structure.node_sets["outer"] = left[np.hypot(*structure.nodes[left, :2].T) > 2.9]
    for name, directions in HELD[held]:
        structure = structure.clamped(name, directions)
    moving = "over_left" if held == "a" else "over_right"
    structure = structure.with_force(moving, [0.1, 0.2, 0.3]).with_preload(moving, [0, 0, 1])
    structure = structure.cyclic(N, "left", "right", (0, 0, 1))
    joint = Joint.between(structure.surface("over_right"), structure.surface("over_left"), next_sector=True, **STIFF)
    assert joint.kind == ("faces" if shift else "pairs")
    structure.join(joint).write(tmp_path / "model.h5")
    (tmp_path / "case.toml").write_text(CASE)
    words_of([BINARY, "reduce", tmp_path / "case.toml", "--out", tmp_path, "-modes_eps_type", "lapack"])
    model = Model.read(tmp_path / "model.h5")
    with h5py.File(tmp_path / "reduced.h5") as file:
        for h in range(N // 2 + 1):
            place = f"cyclic/{h}/" if h else ""
            np.testing.assert_allclose(np.sqrt(file[place + "Kaa"][()]), sector_frequencies(model, h, MODES, "held"), rtol=1e-8)
            found = file[place + "Kxx"][()]
            found = found[..., 0] + 1j * found[..., 1] if h else found
            wanted = condensed(model, h)
            np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-9 * np.abs(wanted).max())


def condensed(model, h):
    """Stiffness of the contact points, all else following."""
    basis = sector_basis(model, h)
    K, c = basis.of(model.K).toarray(), basis.contact.ravel()
    e = np.setdiff1d(np.arange(len(K)), c)
    return K[np.ix_(c, c)] - K[np.ix_(c, e)] @ np.linalg.solve(K[np.ix_(e, e)], K[np.ix_(e, c)])
