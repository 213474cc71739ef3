"""The C++ time integration (build/integrate) against the exact event-driven one of truth.py.

Largest |q - mean| over the cycle, to 1e-4 and better. What is left is the spacing of truth's instants, 1024 in a period.
"""

import json

import numpy as np
import pytest

import cases
import launch
import truth

PROGRAM = launch.BINARY.parent / "integrate"


@pytest.fixture(scope="module", autouse=True)
def program():
    if not (PROGRAM.parent / "CMakeCache.txt").exists():
        pytest.skip(f"{PROGRAM.parent} is no build folder")
    launch.words_of(["cmake", "--build", str(PROGRAM.parent), "--target", PROGRAM.name])


def integrate(case, *words):
    """What the program tells, by frequency."""
    out, _ = launch.words_of([str(PROGRAM), str(case.path), *map(str, words)])
    return [json.loads(line) for line in out.splitlines() if line.startswith("{")]


def exact(case, omega, start=None):
    """Steady state of the reduced model, (dofs, 1024) and its states; `start` (dofs,) from the preload state."""
    r, p = case.reduced, case.preload
    modes, contacts = len(r.kaa), len(r.fx)
    K = np.block([[np.diag(r.kaa), np.zeros((modes, contacts))], [np.zeros((contacts, modes)), r.kxx]])
    M = np.block([[np.eye(modes), r.max], [r.max.T, r.mxx]])
    rest = np.concatenate([np.zeros(modes), p.xp.ravel()])
    orbit = truth.steady_state(M, case.settings["stiffness"], K, modes + np.arange(contacts).reshape(-1, 3), case.contact,
                               np.concatenate([r.fa, r.fx]), case.settings["fourier"],
                               np.concatenate([np.zeros(modes), -r.r]), omega, rest + (0 if start is None else start), p.w,
                               steps=1024, tolerance=1e-7)
    return (orbit.u - rest).T, orbit.states


def without_preload(folder, **overrides):
    """The five dofs, pressed by nothing: the contact is open at rest."""
    structure = cases.Structure(K=20 * np.eye(5) - 10 * np.eye(5, k=1) - 10 * np.eye(5, k=-1), M=np.eye(5),
                                contact_dofs=np.array([[2, 3, 4]]), force=np.array([1.0, 1, 0, 0, 0]), preload=np.zeros(5))
    structure.K[0, 0] = 10
    return cases.full(folder, "five degrees of freedom, not pressed", structure, overrides, modes=2, stiffness=0.05,
                      fourier=[0, 0, 1], normal_stiffness=100.0, tangential_stiffness=[50.0, 50.0], friction=[0.3, 0.3],
                      gap=0.2, initial=0.0, harmonics=10, samples=64, omega=[1.3, 0.6], step=0.05)


# Settings at which the original stops (evidence), where the motion settles, and the delivered one.
SETTINGS = [("delivered", cases.dof5, {}, 1.0215), ("delivered", cases.dof5, {}, 1.05),
            ("k_n = 100", cases.dof5, {"normal_stiffness": 100.0}, 1.19),
            ("k_n = 1000, gap", cases.dof5, {"normal_stiffness": 1000.0, "gap": -0.0035}, 0.9),
            ("k_n = 1000, gap", cases.dof5, {"normal_stiffness": 1000.0, "gap": -0.0035}, 1.3),
            ("not pressed", without_preload, {}, 0.9), ("not pressed", without_preload, {}, 1.0)]


@pytest.mark.parametrize("name, make, changes, omega", SETTINGS, ids=[f"{s[0]} at {s[3]}" for s in SETTINGS])
@pytest.mark.slow
def test_five_dofs(tmp_path, name, make, changes, omega):
    case = make(tmp_path, **changes)
    told, = integrate(case, omega, "--amplitude")
    assert told["settled"] and told["change"] < 1e-6
    motion, states = exact(case, omega)
    assert len(set(states[:, 0, 0])) > 1, "nothing happens at the contact"
    np.testing.assert_allclose(told["amplitude"], np.abs(motion - motion.mean(1)[:, None]).max(1), rtol=1e-4)


@pytest.mark.parametrize("check, omega", [(1, 11.86), (2, 11.86), (2, 8.367)])
@pytest.mark.slow
def test_single_mass_from_rest(tmp_path, check, omega):
    case = cases.single_mass(tmp_path, check)
    told, = integrate(case, omega, "--amplitude")
    assert told["settled"]
    motion, _ = exact(case, omega)
    np.testing.assert_allclose(told["amplitude"], np.abs(motion - motion.mean(1)[:, None]).max(1), rtol=1e-4, atol=1e-9)
