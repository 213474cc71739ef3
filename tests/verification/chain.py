"""The chain on which published tools were timed: contact points in a row and a free tip, every point with its own contact to ground."""

import json

import numpy as np
import scipy.sparse as sp

from dovetail import Model

CASE = """title = "chain, {points} contact points"
model = "model.h5"
reduction = {{ modes = 3 }}
damping = {{ stiffness = 0.02 }}
excitation = {{ fourier = [0, 1] }}
contact = {{ normal_stiffness = {kn!r}, tangential_stiffness = {kt!r}, friction = 0.5 }}
harmonic_balance = {{ harmonics = {harmonics}, samples = {samples}, solver = "{solver}" }}
continuation = {{ omega = [{omega[0]!r}, {omega[1]!r}], at = {at}, max_points = {most} }}
stability = {{ enabled = false }}
accuracy = {{ estimates = false }}
"""


def model(points):
    """3 dofs (t1, t2, n) per node; node 0 hangs on the clamped end, the last one is the tip. The joint is pressed with 1 N in all."""
    nodes = points + 1
    line = 2 * np.eye(nodes) - np.eye(nodes, k=1) - np.eye(nodes, k=-1)
    line[-1, -1] = 1
    K = nodes * sp.kron(sp.csr_matrix(line), np.diag([1.0, 1.5, 2.0]))
    M = sp.eye(3 * nodes) / nodes
    force, preload = np.zeros(3 * nodes), np.zeros(3 * nodes)
    force[-3], force[-1] = 0.1, 0.05
    preload[2:-3:3] = 1 / points
    return Model(K.tocsc(), M.tocsc(), np.arange(3 * points).reshape(-1, 3), force, preload)


def write(folder, points, harmonics=5, samples="exact", solver="modal", omega=(0.8, 2.6), at=(), most=20000):
    """model.h5 and case.toml in a folder; path of the case."""
    folder.mkdir(parents=True, exist_ok=True)
    model(points).write(folder / "model.h5")
    path = folder / "case.toml"
    path.write_text(CASE.format(points=points, kn=2 / points, kt=1 / points, harmonics=harmonics, samples=json.dumps(samples),
                                solver=solver, omega=[float(w) for w in omega], at=json.dumps(list(at)), most=most))
    return path
