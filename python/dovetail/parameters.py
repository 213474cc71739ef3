"""Contact parameters: known names, and one row per contact point of each."""

import numpy as np

CONTACT_WIDTH = {"normal_stiffness": 1, "tangential_stiffness": 2, "friction": 2, "gap": 1}


def contact_parameters(contact, n_points):
    """Every parameter given, one row per contact point: (N_x,) or (N_x, 2)."""
    unknown = set(contact) - set(CONTACT_WIDTH)
    if unknown:
        raise ValueError(f"contact has unknown {sorted(unknown)}; known are {sorted(CONTACT_WIDTH)}")
    rows = {}
    for name, given in contact.items():
        shape = (n_points,) if CONTACT_WIDTH[name] == 1 else (n_points, 2)
        given = np.asarray(given, dtype=np.float64)
        if given.shape not in ((), shape, shape[1:]):
            choices = "a number or one per point" if len(shape) == 1 else "a number, [t1, t2] or one such pair per point"
            raise ValueError(f"contact {name} must be {choices} ({n_points} points), found shape {given.shape}")
        values = np.broadcast_to(given, shape).copy()
        if not np.all(np.isfinite(values)):
            raise ValueError(f"contact {name} must be finite")
        if name.endswith("stiffness") and values.min() <= 0:
            raise ValueError(f"contact {name} must be positive, found {values.min():g}")
        if name == "friction" and values.min() < 0:
            raise ValueError(f"contact friction must not be negative, found {values.min():g}")
        rows[name] = values
    return rows
