"""pyHarm on one chain, in an interpreter of its own: started by field.py, asked by JSON on stdin, answers on stdout.

Matrices, damping and forces are those of the reference, with pyHarm's own frequency response analysis, its Newton-Raphson method and its
element for contact with friction, Penalty3D. That one measures from the preload state, with opening positive.
"""

import json
import sys
import time

import numpy as np
from pyHarm.Maestro import Maestro


def analysis(asked):
    """The frequency response analysis of the chain."""
    K, M, force = (np.array(asked[name]) for name in ("K", "M", "force"))
    nodes = len(K) // 3
    force[2::3] *= -1  # opening is positive
    elements = {f"contact {j}": {"type": "Penalty3D", "connect": {"chain": [j]}, "dirs": [2, 0, 1], "mu": asked["mu"], "N0": N0, "g": 0.0,
                                 "k_n": asked["kn"], "k_t": asked["kt"]} for j, N0 in enumerate(asked["N0"])}
    elements |= {f"force {d}": {"type": "CosinusForcing", "connect": {"chain": [nodes - 1]}, "dirs": [d], "amp": float(force[-3 + d])}
                 for d in (0, 2)}
    omegas = asked["omegas"]
    maestro = Maestro({
        "system": {"type": "Base", "nh": asked["harmonics"], "nti": asked["samples"]},
        "substructures": {"chain": {"matrix": {"M": M, "K": K, "C": asked["xi"] * K}, "ndofs": 3}},
        "connectors": elements,
        "analysis": {"curve": {"study": "frf", "solver": "NewtonRaphson", "solver_options": {"max_iter": 100}, "verbose": False,
                               "puls_inf": omegas[0], "puls_sup": omegas[-1], "stepsizer": "constant", "predictor": "previous",
                               "corrector": "nocontinuation"}}})
    return maestro.nls["curve"]


def curve(asked):
    """First harmonic amplitudes of the tip at all frequencies asked for, or all harmonics of the `node` asked for, and the seconds of all
    but the first frequency."""
    omegas, study = asked["omegas"], analysis(asked)
    dofs = study.system.expl_dofs
    node, highest = asked.get("node", dofs.node_num.max()), asked["harmonics"] if "node" in asked else 1
    shown = dofs[(dofs.node_num == node) & (dofs.dof_num == 0) & (dofs.harm >= 1) & (dofs.harm <= highest)].index
    study.initialise()  # compiles, too
    began = time.process_time()
    for before, omega in zip(omegas, omegas[1:]):
        study.ds = omega - before
        study.makeStep()
        study.purge_jacobians()
        if not study.SolList[-1].flag_accepted:
            sys.exit(f"no convergence at {omega:.6g}")
    seconds = time.process_time() - began
    return {"amplitudes": [float(np.linalg.norm(point.x[shown])) for point in study.SolList], "seconds": seconds}


if __name__ == "__main__":
    print(json.dumps(curve(json.load(sys.stdin))))
