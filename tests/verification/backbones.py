"""Nonlinear modes of small structures, by Newton's method on the NumPy reference: extended periodic motions, amplitude by amplitude."""

import numpy as np
import scipy.linalg

from dovetail import reference
from dovetail.modes import Backbone
from dovetail.reduced_system import stuck


def system_of(data, samples, harmonics=None):
    """The equations of dof5.npz or chain.npz."""
    par, x = data["par"], 3 * len(data["par"])
    K, M, load = data["K"], data["M"], data["load"]
    course = int(np.argmax(np.abs(load).max(axis=0)))
    reduced = reference.Reduced(np.diag(K)[:-x].copy(), M[:-x, -x:], M[-x:, -x:], K[-x:, -x:], load[:-x, course], load[-x:, course],
                                -data["static"][-x:])
    contact = reference.Contact(par[:, 0], par[:, 1:3], par[:, 3:5], par[:, 5])
    fourier = [0.0] * course + [1.0]
    damping = reference.Damping(matrix=data["C"])
    return reference.HarmonicBalance(reduced, contact, reference.contact_preload(reduced, contact), damping, fourier,
                                     harmonics or int(data["H"]), samples)


def mode(system, alphas, number=1):
    """A Backbone at these amplitudes, the first of them below every onset of slip and lift-off."""
    squares, shapes = scipy.linalg.eigh(stuck(system), system.M)
    phi, omega = shapes[:, number - 1], np.sqrt(squares[number - 1])
    n, size = system.shape
    psi = np.zeros(system.shape)
    psi[:, 1] = phi
    u = np.concatenate([psi.ravel(), [omega, phi @ system.C @ phi / (2 * omega)]])
    constant = np.zeros_like(system.excitation)
    constant[:, 0] = system.excitation[:, 0]
    found, before = [], phi
    for alpha in alphas:
        for _ in range(40):
            residual, jacobian = _equations(system, u, alpha, constant, before)
            step = np.linalg.solve(jacobian, -residual)
            u = u + step
            if np.linalg.norm(step) < 1e-9 * np.linalg.norm(u):
                break
        else:
            raise RuntimeError(f"no mode at amplitude {alpha}")
        before = u[:-2].reshape(n, size)[:, 1].copy()
        found.append(u)
    found = np.array(found)
    q = found[:, :-2].reshape(-1, n, size).copy()
    q[:, :, 1:] *= np.asarray(alphas)[:, None, None]
    return Backbone(np.asarray(alphas), found[:, -2], found[:, -1], q, system)


def _equations(system, u, alpha, constant, before):
    """Residual and Jacobian in [Psi, omega, zeta]; harmonics but the mean divided by alpha."""
    n, size = system.shape
    psi, omega, zeta = u[:-2].reshape(n, size), u[-2], u[-1]
    scale = np.ones(size)
    scale[1:] = alpha
    q = psi * scale
    D = system.dynamic_stiffness(omega) - system.harmonic_blocks(lambda k: 0 * system.M, lambda k: 2 * zeta * omega * k * omega * system.M)
    J = system.jacobian(q, omega) - system.dynamic_stiffness(omega) + D
    R = system.residual(q, omega).ravel() + system.excitation.ravel() - constant.ravel() + (D - system.dynamic_stiffness(omega)) @ q.ravel()
    rows = np.tile(scale, n)
    by_omega = system.harmonic_blocks(lambda k: -2 * k**2 * omega * system.M * (k > 0),
                                      lambda k: k * system.C - 4 * zeta * omega * k * system.M) @ q.ravel()
    by_zeta = system.harmonic_blocks(lambda k: 0 * system.M, lambda k: -2 * omega**2 * k * system.M) @ q.ravel()
    by_omega.reshape(n, size)[:, 0] = 0
    by_zeta.reshape(n, size)[:, 0] = 0
    c, s = psi[:, 1], psi[:, 2]
    norm, phase = np.zeros((n, size)), np.zeros((n, size))
    norm[:, 1], norm[:, 2], phase[:, 2] = 2 * system.M @ c, 2 * system.M @ s, system.M @ before
    top = np.column_stack([J * rows / rows[:, None], by_omega / rows, by_zeta / rows])
    bottom = np.column_stack([np.vstack([norm.ravel(), phase.ravel()]), np.zeros((2, 2))])
    return (np.concatenate([R / rows, [c @ system.M @ c + s @ system.M @ s - 1, before @ system.M @ s]]), np.vstack([top, bottom]))
