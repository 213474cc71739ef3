"""A cyclic model by its file: frequencies of every nodal diameter against an independent program, and the rotor assembled of sectors."""

import numpy as np
import pytest
import sector

from dovetail import Model
from dovetail.reference import sector_frequencies


@pytest.fixture(scope="module")
def model(tmp_path_factory):
    path = tmp_path_factory.mktemp("sector") / "model.h5"
    sector.model().write(path)
    return Model.read(path)


@pytest.mark.parametrize("contact", ["stuck", "held"])
@pytest.mark.parametrize("h", range(sector.N // 2 + 1))
def test_frequencies_of_each_nodal_diameter(model, h, contact):
    """Waves of both directions have the same."""
    for index in (h, -h):
        np.testing.assert_allclose(sector_frequencies(model, index, 20, contact), sector.ANSWERS[contact][h], rtol=1e-10)


@pytest.mark.parametrize("contact, free", [("stuck", 0), ("open", 6 * sector.N)])
def test_all_nodal_diameters_are_the_whole_rotor(model, contact, free):
    """Every frequency of the assembled rotor, those of 0 < h < N/2 twice. Open joints leave every blade its rigid motions."""
    everything = [sector_frequencies(model, h, model.n, contact) for h in range(sector.N // 2 + 1)]
    found, wanted = np.sort(np.concatenate(everything + everything[1:-1])), np.sort(sector.ANSWERS[f"rotor_{contact}"])
    np.testing.assert_allclose(found[free:], wanted[free:], rtol=1e-9)
    assert np.all(found[:free] < 1e-3 * wanted[free])
