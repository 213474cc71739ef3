"""Labels of units: what they are called in pictures and in words."""

from pathlib import Path

import pytest

from dovetail.units import parse, with_unit

TABLE = Path(__file__).parents[1] / "units.txt"


def cases():
    for line in TABLE.read_text().splitlines():
        if not line.startswith("#"):
            yield [word.strip() for word in line.split("|")]


@pytest.mark.parametrize("case", cases(), ids=lambda case: case[0] or "empty")
def test_a_label_is_understood_or_gives_plain_numbers(case):
    label, *names, hertz = case
    units = parse(label)
    assert [units.length, units.mass, units.time, units.force, units.energy, units.stress, units.modal, units.omega] == names
    assert units.hertz(1.0) == pytest.approx(float(hertz), rel=1e-15)
    assert units.from_hertz(units.hertz(7.0)) == pytest.approx(7.0, rel=1e-15)
    assert units.known == bool(names[0])


def test_what_is_made_of_units_has_none_where_nothing_is_known():
    known, unknown = parse("t, mm, s, N"), parse("none")
    assert (known.stiffness, known.area, known.work_per_area) == ("N/mm", "mm²", "mJ/mm²")
    assert (unknown.stiffness, unknown.area, unknown.work_per_area) == ("", "", "")
    assert (with_unit("1.5", known.length), with_unit("1.5", unknown.length)) == ("1.5 mm", "1.5")
