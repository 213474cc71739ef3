"""What all contact points do at equal steps of a period, of any sector: forces, states, gaps, and what a period amounts to."""

from dataclasses import dataclass

import numpy as np

from . import fourier, reference
from .contact_motion import parameters_at

LEAST = 1024  # samples of a period: sliders are dragged from one to the next
STICKS, SLIPS, OPEN = reference.STICK, 1, reference.OPEN  # SLIPS, in either direction


@dataclass(frozen=True)
class ContactPeriod:
    """N samples of a period, of N_x contact points of sector 0; vectors are t1, t2, n of each point.

    relative : (N_x, N, 3) total relative displacement; force : (N_x, N, 3) T1, T2, N that side a exerts on side b
    state : (N_x, N) STICKS, SLIPS (in at least one direction) or OPEN; gap : (N_x, N) positive where open, else how far it is pressed in
    slip_path : (N_x,) way of the slider in a period, while closed; slip, open : (N_x,) shares of the period
    energy : (N_x,) that friction takes in a period
    """

    relative: np.ndarray
    force: np.ndarray
    state: np.ndarray
    gap: np.ndarray
    slip_path: np.ndarray
    slip: np.ndarray
    open: np.ndarray
    energy: np.ndarray

    def at(self, share):
        """Number of the sample at a share of the period, which may lie outside of 0 to 1."""
        samples = self.force.shape[1]
        return int(round(share * samples)) % samples


def samples_of(frames, wave=None):
    """Samples of a period among which every frame of every sector is one, no fewer than LEAST."""
    later = 1 if wave is None else wave.sectors // np.gcd(wave.sectors, wave.engine_order % wave.sectors)
    every = int(np.lcm(frames, later))
    return every * -(-LEAST // every)


def contact_period(results, point, samples):
    """The ContactPeriod of a point of the branch."""
    X = results.coefficients_at(point)[results.modes:].reshape(results.contact_points, 3, -1)
    basis = fourier.basis(results.harmonics, fourier.phases(samples))
    x, xp = np.einsum("sk,pdk->psd", basis, X), results.xp.reshape(-1, 3)
    contact, w = parameters_at(results, point)
    kt, gap = contact["tangential_stiffness"], contact["gap"]
    force, state = reference.law(x, xp, w, contact["normal_stiffness"], kt, contact["friction"], gap, contact["law"])
    relative = x + xp[:, None]
    is_open = (state == OPEN).any(axis=2)
    foot = relative[..., :2] - force[..., :2] / np.where(kt > 0, kt, 1)[:, None]
    closed = ~is_open & ~np.roll(is_open, 1, axis=1) & (kt > 0).all(axis=1)[:, None]
    steps = np.linalg.norm(foot - np.roll(foot, 1, axis=1), axis=2)
    steps[(state == STICKS).all(axis=2)] = 0.0  # round-off where it sticks
    activity = results.contact_activity(point)
    said = np.where(is_open, OPEN, np.where((np.abs(state) == SLIPS).any(axis=2), SLIPS, STICKS))
    return ContactPeriod(relative, force, said, gap[:, None] - relative[..., 2], np.sum(steps * closed, axis=1), activity.slip,
                         activity.open, np.maximum(activity.dissipation, 0.0))  # round-off of a loop without area
