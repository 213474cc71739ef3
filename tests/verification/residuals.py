"""What motions of curves of the atlas miss of the equations of harmonic balance, in plain Python."""

import sys

import numpy as np

from launch import ROOT

sys.path.insert(0, str(ROOT / "scripts/bench"))
import atlas_methods


def residuals(built, omega, q, samples=8192):
    """For motions (k, n, 2H + 1) at k frequencies: residuals over excitation and contact forces together. Samples of the latter, in place
    of exact forces, miss a part: with the default less than 1e-4 of them unless contacts as good as rigid open."""
    system = atlas_methods.Plain(*atlas_methods.arguments(built, harmonics=q.shape[2] // 2, samples=samples))
    forces = system.forces(q[:, system.modes:].reshape(len(q), -1, 3, q.shape[2]))
    found = []
    for w, motion, force in zip(omega, q, forces):
        r = (system.dynamic_stiffness(w) @ motion.ravel()).reshape(system.shape) - system.excitation
        r[system.modes:] += force.reshape(-1, system.shape[1])
        found.append(np.linalg.norm(r) / (np.linalg.norm(system.excitation) + np.linalg.norm(force)))
    return np.array(found)
