"""The scenes of the atlas that have names: the settings at which the published algorithm stops, and the checks of separation.

dof5 is the five-degree-of-freedom example of inputs/dof5; mass 1 and 2 are the single-mass checks of tests/verification, mass 1 open the
first with a clearance of 10; stop is the two-mass chain against a stop of scripts/bench/sweeps. "back" sweeps from the other end.
"""

import numpy as np

import atlas_structures as structures
from atlas_structures import cases

from dovetail import reference

FAR = 1e4  # [N/m] stiffness of directions that nothing excites


def dof5(kn=1.0, gap=-3.5, kt=1.0, mu=1.0, preload=1.0, force=1.0, omega=(0.9, 1.3), H=10, step=1.0):
    """K 10 N/m, mass 1 kg; the sweep and the step of the original as delivered, `step` times as long."""
    made = structures.dof5()
    structure = cases.Structure(made.K, made.M, made.contact_dofs, force * made.force, preload * made.press)
    contact = reference.Contact.uniform(1, kn, kt, mu, gap)
    return numbers(structure, contact, 2, 0.05, [0, 0, 1], omega, H, 0.02 * step, 0.05 * step, initial=1e-5)


def mass(check, kn=120.0, static=-800.0, omega=(5.0, 16.0), H=10):
    """1 kg on 40 N/m, excited with 100 N, pressed by 800 N; a mode that nothing couples or excites."""
    force = np.array([0.0, 0, 100, 0]) if check == 1 else np.array([100.0, 0, 100, 0])
    structure = cases.Structure(np.diag([40.0, 40, 40, 1]), np.eye(4), np.array([[0, 1, 2]]), force, np.array([0.0, 0, -static, 0]))
    contact = reference.Contact.uniform(1, kn, 30.0, 0.3 if check == 1 else 8.0, 0.0)
    return numbers(structure, contact, 1, 0.01, [0, 0, 1], omega, H, 0.02, 0.5)


def stop(omega=(0.8, 0.5), H=25):
    """K = [[1, -1], [-1, 2]], xi = 0.03, 0.1 cos on the second mass, the first against a stop of 100 N/m at 1 m."""
    K = np.diag([1.0, 2, FAR, FAR])
    K[0, 1] = K[1, 0] = -1
    structure = cases.Structure(K, np.eye(4), np.array([[2, 3, 0]]), np.array([0, 0.1, 0, 0]), np.zeros(4))
    return numbers(structure, reference.Contact.uniform(1, 100.0, 1.0, 0.0, 1.0), 1, 0.03, [0, 1], omega, H, 0.02, 0.02)


def numbers(structure, contact, modes, xi, fourier, omega, harmonics, step, arc, initial=0.0):
    """Keyword arguments of `atlas_scenes.Built`."""
    reduced = reference.craig_bampton(structure.K, structure.M, structure.contact_dofs, structure.force, structure.preload, modes)
    return dict(structure=structure, contact=contact, reduced=reduced, modes=modes, xi=xi, fourier=fourier, omega=omega,
                harmonics=harmonics, delivered=min(harmonics, 10), step=step, arc=arc, initial=initial)


def turned(made):
    return {**made, "omega": made["omega"][::-1]}


LOW = (1.3, 0.6)  # down through the resonances of the example with stiff contacts
SETTINGS = {  # what to build, and its place in the map: stiffness, friction, press, gap, force, damping as in `Scene`
    "dof5": (lambda: dof5(), (0.1, 1.0, 0.33, 0.0, 0.1, 0.025)),
    "dof5 step x40": (lambda: dof5(step=40.0), (0.1, 1.0, 0.33, 0.0, 0.1, 0.025)),
    "dof5 force x10": (lambda: dof5(force=10.0), (0.1, 1.0, 0.33, 0.0, 1.0, 0.025)),
    "dof5 kn 100": (lambda: dof5(kn=100.0), (10.0, 1.0, 1.0, 0.0, 0.1, 0.025)),
    "dof5 kn 100 down": (lambda: dof5(kn=100.0, omega=LOW), (10.0, 1.0, 1.0, 0.0, 0.1, 0.025)),
    "dof5 kn 100 H 25 down": (lambda: dof5(kn=100.0, omega=LOW, H=25), (10.0, 1.0, 1.0, 0.0, 0.1, 0.025)),
    "dof5 kn 1000": (lambda: dof5(kn=1000.0), (100.0, 1.0, 1.0, 0.0, 0.1, 0.025)),
    "dof5 kn 1000 down": (lambda: dof5(kn=1000.0, omega=LOW), (100.0, 1.0, 1.0, 0.0, 0.1, 0.025)),
    "dof5 kn 1000 H 40 down": (lambda: dof5(kn=1000.0, omega=LOW, H=40), (100.0, 1.0, 1.0, 0.0, 0.1, 0.025)),
    "dof5 kn 1000 gap": (lambda: dof5(kn=1000.0, gap=-0.0035), (100.0, 1.0, 0.01, 0.0, 0.1, 0.025)),
    "dof5 kn 1000 gap down": (lambda: dof5(kn=1000.0, gap=-0.0035, omega=LOW), (100.0, 1.0, 0.01, 0.0, 0.1, 0.025)),
    "dof5 kn 1000 gap H 60": (lambda: dof5(kn=1000.0, gap=-0.0035, H=60), (100.0, 1.0, 0.01, 0.0, 0.1, 0.025)),
    "dof5 open gap": (lambda: dof5(kn=100.0, gap=0.2, kt=50.0, mu=0.3, preload=0.0), (10.0, 0.3, 0.0, 0.2, 0.1, 0.025)),
    "dof5 open gap down": (lambda: dof5(kn=100.0, gap=0.2, kt=50.0, mu=0.3, preload=0.0, omega=LOW), (10.0, 0.3, 0.0, 0.2, 0.1, 0.025)),
    "dof5 open gap H 25": (lambda: dof5(kn=100.0, gap=0.2, kt=50.0, mu=0.3, preload=0.0, H=25), (10.0, 0.3, 0.0, 0.2, 0.1, 0.025)),
    "mass 1": (lambda: mass(1), (3.0, 0.3, 5.0, 0.0, 2.5, 0.03)),
    "mass 1 back": (lambda: turned(mass(1)), (3.0, 0.3, 5.0, 0.0, 2.5, 0.03)),
    "mass 1 open": (lambda: mass(1, static=400.0, omega=(4.0, 14.0)), (3.0, 0.3, 0.0, 10.0, 2.5, 0.03)),
    "mass 1 open back": (lambda: mass(1, static=400.0, omega=(14.0, 4.0)), (3.0, 0.3, 0.0, 10.0, 2.5, 0.03)),
    "mass 2": (lambda: mass(2), (3.0, 8.0, 5.0, 0.0, 2.5, 0.03)),
    "mass 2 back": (lambda: turned(mass(2)), (3.0, 8.0, 5.0, 0.0, 2.5, 0.03)),
    "stop": (lambda: stop(), (100.0, 0.0, 0.0, 1.0, 0.1, 0.01)),
    "stop back": (lambda: turned(stop()), (100.0, 0.0, 0.0, 1.0, 0.1, 0.01)),
}


def scenes(scene_type):
    """One scene for each setting."""
    made = []
    for name, (_, (stiffness, friction, press, gap, force, damping)) in SETTINGS.items():
        made.append(scene_type(name=name.replace(" ", "_"), family="evidence", points=1, stiffness=stiffness, tangential=1.0,
                               friction=friction, press=press, gap=gap, force=force, damping=damping,
                               backward=name.endswith(("back", "down")), three=False, step=40.0 if "x40" in name else 1.0, units="1",
                               seed=0))
    return made


def build(scene, built_type):
    return built_type(name=scene.name, **SETTINGS[scene.name.replace("_", " ")][0]())
