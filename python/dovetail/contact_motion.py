"""What contact points do over a period: forces, friction loops, states. See `Results`."""

from dataclasses import dataclass, fields

import numpy as np

from . import fourier
from .checked import whole_number
from .hdf5_read import patiently


@dataclass(frozen=True)
class ContactActivity:
    """What every contact point does over one period.

    stick, slip, open : (N_x,) shares of the period, 1 together; slip in at least one direction
    events : (N_x,) number of lift-offs, landings, slip onsets and ends of slip
    dissipation : (N_x,) energy taken from the structure [J]
    """

    stick: np.ndarray
    slip: np.ndarray
    open: np.ndarray
    events: np.ndarray
    dissipation: np.ndarray


def force(results, point, contact, n=None, sector=None):
    """Total force g(x + x_p) of a contact point over the period.

    Parameters
    ----------
    results : Results
    point : int
    contact : int
        One-based number of the contact point.
    n : int, optional
        Samples over the period, default those of the run; `drawing_samples` where it took none.
    sector : int, optional
        Of a cyclic structure; default 0.

    Returns
    -------
    force : (n, 3)
        T1, T2, N [N].
    state : (n, 2) int
        Per tangential direction: 0 stick, 1 slip forward, -1 slip backward, 2 open.
    """
    from . import reference

    j, (parameters, w) = index(results, contact), parameters_at(results, point)
    law = (parameters[name][j] for name in ("normal_stiffness", "tangential_stiffness", "friction", "gap", "law"))
    return reference.law(_motion(results, point, j, n, sector), results.xp[3 * j:3 * j + 3], w[j], *law)


def hysteresis(results, point, contact, direction=0, n=None, sector=None):
    """As `Results.hysteresis`."""
    if direction not in (0, 1):
        raise ValueError(f"direction must be 0 (t1) or 1 (t2), found {direction!r}")
    j = index(results, contact)
    x = _motion(results, point, j, n, sector)[:, direction] + results.xp[3 * j + direction]
    return x, force(results, point, contact, n, sector)[0][:, direction]


def parameters_at(results, point):
    """Parameters of the contact points as `Results.contact`, and feet of their sliders at rest (N_x, 2), at a point of the curve: those
    of the case, or of a sweep over another parameter of the joint those with its value there."""
    from .reduced_system import LOADS, at_rest

    if results.parameter is None or results.modal_amplitude is not None or results.parameter_name in LOADS:
        return results.contact, results.w
    value = float(results.parameter[point])
    if value not in results._at_rest:
        contact, preload = at_rest(results, value)
        results._at_rest[value] = {**results.contact, "normal_stiffness": contact.kn, "tangential_stiffness": contact.kt,
                                  "friction": contact.mu, "gap": contact.gap}, preload.w
    return results._at_rest[value]


def activity(results, point):
    """As `Results.contact_activity`."""
    row = slice(len(results)) if point is None else results.number(point)
    if not results.has_activity:
        raise ValueError(f"{results.path}: has no /points/contact: it was written by an older version; run the case again")
    names = [field.name for field in fields(ContactActivity)]
    return ContactActivity(**patiently(results.path, lambda file: {name: file["points/contact"][name][row] for name in names}))


def index(results, contact):
    """Number from zero of a contact point."""
    return whole_number(contact, "contact point", 1, results.contact_points) - 1


def _motion(results, point, j, n, sector):
    rows = results.coefficients_at(point, sector)[results.modes + 3 * j:results.modes + 3 * j + 3]
    return fourier.basis(results.harmonics, fourier.phases(results.drawing_samples if n is None else n)) @ rows.T
