"""A sector made in Python, reduced by the program: frequencies of every nodal diameter against sparse algebra in Python."""

import h5py
import launch
import numpy as np
import pytest
from ring import N, sector
from test_cyclic import cyclic, shroud

from dovetail import Model
from dovetail.reference import sector_frequencies


class Case:
    def __init__(self, path):
        self.path = path


@pytest.mark.parametrize("shift, held", [(0.0, None), (0.3, None), (0.0, "over_left"), (0.0, "over_right")])
def test_frequencies_with_contact_points_held(tmp_path, shift, held):
    """Pairs of nodes, nodes on faces of the next sector, and points whose one side does not move; about the z axis, five sectors."""
    structure = cyclic(sector(shift=shift).clamped("bore") if held is None else sector().clamped("bore").clamped(held))
    structure.join(shroud(structure)).write(tmp_path / "model.h5")
    with h5py.File(tmp_path / "model.h5", "a") as file:
        file["force"][...] = 1.0
    case = tmp_path / "case.toml"
    case.write_text('model = "model.h5"\nreduction = { modes = 8, exact_modes = true }\nexcitation.engine_order = 1\n'
                    "excitation.fourier = [0, 1]\nharmonic_balance.harmonics = 1\ncontinuation.omega = [1.0, 2.0]\n")
    launch.run(Case(case), command="reduce")
    model = Model.read(tmp_path / "model.h5")
    with h5py.File(tmp_path / "reduced.h5") as file:
        for h in range(N // 2 + 1):
            found = np.sqrt(file[f"cyclic/{h}/Kaa" if h else "Kaa"][()])
            np.testing.assert_allclose(found, sector_frequencies(model, h, 8, "held"), rtol=1e-9)
