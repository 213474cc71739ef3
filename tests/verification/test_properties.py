"""Some examples of each property of random structures; `scripts/properties` takes thousands."""

import pytest

from properties import PROPERTIES, Count, judge

QUICK = 4  # examples each, 56 in all


@pytest.mark.parametrize("examples, seed", [(QUICK, 0), pytest.param(12, 1, marks=pytest.mark.slow)])
@pytest.mark.parametrize("name", PROPERTIES)
def test_a_property_holds_of_random_structures(name, examples, seed):
    count = Count()
    judge(name, examples, seed, count)
    assert count.judged == examples and count.others < examples / 2
