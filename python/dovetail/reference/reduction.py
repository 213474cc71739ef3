"""Reduction of a full model, and the preload state of its contact points."""

from dataclasses import dataclass

import numpy as np
import scipy.linalg

from .contact import BILATERAL, CONE, rubbed
from .newton import newton


@dataclass(frozen=True)
class Reduced:
    """Craig-Bampton model: kaa, fa (N_a,); max (N_a, n_c); mxx, kxx (n_c, n_c); fx, r (n_c,); n_c = 3 N_x.

    With several load patterns fa is (L, N_a) and fx (L, n_c).
    """

    kaa: np.ndarray
    max: np.ndarray
    mxx: np.ndarray
    kxx: np.ndarray
    fa: np.ndarray
    fx: np.ndarray
    r: np.ndarray


@dataclass(frozen=True)
class Preload:
    """Preload state of the contact points: xp (N_x, 3) [m], g (N_x, 3) [N], w (N_x, 2) [m]."""

    xp: np.ndarray
    g: np.ndarray
    w: np.ndarray


def split(K, M, contact_dofs):
    """Elastic dofs (all others, ascending), contact dofs (t1, t2, n of each point), and K, M as dense arrays."""
    K, M = (A.toarray() if hasattr(A, "toarray") else np.asarray(A, float) for A in (K, M))
    c = np.asarray(contact_dofs).ravel()
    return np.setdiff1d(np.arange(len(K)), c), c, K, M


def bases(K, M, contact_dofs, modes):
    """Fixed-interface modes Phi, their w^2 (15), and constraint modes Psi (16)."""
    e, c, K, M = split(K, M, contact_dofs)
    squares, phi = scipy.linalg.eigh(K[np.ix_(e, e)], M[np.ix_(e, e)])
    squares, phi = squares[:modes], phi[:, :modes]
    for mode in phi.T:  # sign: the largest entry is positive, the first one where several are equally large
        largest = np.abs(mode).max()
        mode *= np.sign(mode[np.argmax(np.abs(mode) > (1 - 1e-6) * largest)])
    return squares, phi, -np.linalg.solve(K[np.ix_(e, e)], K[np.ix_(e, c)])


def craig_bampton(K, M, contact_dofs, force, preload, modes):
    """Reduce a full model (1) to its contact dofs and `modes` fixed-interface modes: (2), (5), (15)-(18).

    K, M : (n, n) sparse or dense; contact_dofs : (N_x, 3) indices of t1, t2, n; force, preload : (n,) [N].
    force : (L, n) with several load patterns.
    """
    squares, phi, psi = bases(K, M, contact_dofs, modes)
    e, c, K, M = split(K, M, contact_dofs)
    force = np.asarray(force, float)
    Kee, Kec, Kcc = K[np.ix_(e, e)], K[np.ix_(e, c)], K[np.ix_(c, c)]
    Mee, Mec, Mcc = M[np.ix_(e, e)], M[np.ix_(e, c)], M[np.ix_(c, c)]
    return Reduced(kaa=squares,
                   max=phi.T @ (Mee @ psi + Mec),
                   mxx=psi.T @ Mee @ psi + psi.T @ Mec + Mec.T @ psi + Mcc,
                   kxx=Kcc + Kec.T @ psi,
                   fa=force[..., e] @ phi,
                   fx=force[..., e] @ psi + force[..., c],
                   r=Kec.T @ np.linalg.solve(Kee, preload[e]) - preload[c])


def projected(C, K, M, contact_dofs, modes):
    """Another matrix, of damping, in the unknowns of `craig_bampton`: (N_a + 3 N_x, N_a + 3 N_x)."""
    e, c, *_ = split(K, M, contact_dofs)
    _, phi, psi = bases(K, M, contact_dofs, modes)
    basis = np.zeros((len(e) + len(c), modes + len(c)))
    basis[e, :modes], basis[e, modes:], basis[c, modes:] = phi, psi, np.eye(len(c))
    return basis.T @ (C.toarray() if hasattr(C, "toarray") else np.asarray(C, float)) @ basis


def static_force(x, contact):
    """Force reached in one step from a foot at zero: g (N_x, 3) at total displacement x (N_x, 3), and the foot then, w (N_x, 2)."""
    rubs, cone = (contact.kind <= CONE)[:, None], (contact.kind == CONE)[:, None]
    p = x[:, 2] - contact.gap
    is_open = (p.real <= 0) & (contact.kind != BILATERAL)
    normal = np.where(is_open, 0, contact.kn * p)
    kt = np.where(rubs, contact.kt, 1)
    tangential, sign = rubbed(kt * x[:, :2], contact.mu * normal[:, None], cone)
    tangential = np.where(is_open[:, None] | ~rubs, 0, tangential)
    moves = rubs & (is_open[:, None] | (sign != 0))
    w = np.where(moves, x[:, :2] - tangential / kt, 0)
    return np.column_stack([tangential, normal]), w


def static_law(x, contact):
    """`static_force` and its derivative by complex step: g (N_x, 3), w (N_x, 2), dg/dx (N_x, 3, 3).

    In the derivative p = 0 counts as closed and stuck, so that a body held by its joint alone can be pushed onto it.
    """
    h = 1e-30
    slope = np.stack([static_force(x + 1j * h * direction, contact)[0].imag / h for direction in np.eye(3)], axis=2)
    springs = np.column_stack([(contact.kind <= CONE)[:, None] * contact.kt, contact.kn])
    touching = x[:, 2] == contact.gap
    slope[touching] = springs[touching, :, None] * np.eye(3)
    return *static_force(x, contact), slope


def contact_preload(reduced, contact, initial=0.0):
    """Solve K_xx xp + g(xp) = -R (7) by Newton's method from `initial` (a number, or one per contact dof) [m]."""
    def residual(x):
        return reduced.kxx @ x + static_law(x.reshape(-1, 3), contact)[0].ravel() + reduced.r

    def jacobian(x):
        return reduced.kxx + scipy.linalg.block_diag(*static_law(x.reshape(-1, 3), contact)[2])

    start = np.broadcast_to(np.asarray(initial, float), reduced.r.shape)
    xp = newton(residual, jacobian, start).reshape(-1, 3)
    g, w, _ = static_law(xp, contact)
    return Preload(xp, g, w)
