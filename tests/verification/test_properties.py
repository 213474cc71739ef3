"""Some examples of each property of random structures; `scripts/properties` takes thousands."""

import pytest

import cases
from properties import PROPERTIES, Count, judge
from random_cases import TIGHT, Runs, Scene

QUICK, SLOW = 2, 8  # examples each, 28 and 112 in all


@pytest.mark.parametrize("examples, seed", [(QUICK, 0), pytest.param(SLOW, 1, marks=pytest.mark.slow)])
@pytest.mark.parametrize("name", PROPERTIES)
def test_a_property_holds_of_random_structures(name, examples, seed):
    count = Count()
    judge(name, examples, seed, count)
    assert count.judged >= examples / 2 and count.others < examples / 2


def test_a_motion_that_is_a_thousandth_off_is_no_other_solution():
    settings = {"modes": 3, "stiffness": 0.02, "fourier": [0.2, 1.0, 0.5], "law": ["coulomb", "unilateral"], "normal_stiffness": 3.0,
                "tangential_stiffness": [1.0, 2.0], "friction": [0.3, 0.4], "gap": -0.1, "initial": 0.0, "harmonics": 3, "samples": "exact",
                "omega": [1.0, 1.0], "kind": "auto", "estimates": False, "enabled": False, **TIGHT}
    with Runs() as runs:
        answer = runs.solve(Scene(cases.random_structure(4, 2), settings))
        runs.same(answer.X, answer)
        with pytest.raises(AssertionError, match="motions differ by 1.0e-03"):
            runs.same(answer.X * 1.001, answer)
