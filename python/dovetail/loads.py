"""Forces at the nodes of a structure: shares of a force, of a moment, of a pressure; inertia; and what a phase makes of them.

Patterns are real. A force with a phase is two of them, the second a quarter period later: Re(F exp(i omega t)) =
Re(F) cos(omega t) - Im(F) sin(omega t).
"""

import numpy as np

from .sparse_rows import is_petsc

LATER = "_sin"  # ending of the name of the second pattern of a force with a phase
FORTH, LATE = [0.0, 1.0], [0.0, 0.0, 1.0]  # courses cos(omega t) and sin(omega t)
RIGID = 1e-8  # of the largest row sum of |K| |r|, for K r of a motion that nothing holds: rounding of matrices in text files


def numbers_of(values, name, shape, unit):
    """Real or complex array of that shape."""
    values = np.asarray(values)
    if values.shape != shape or values.dtype.kind not in "iufc" or not np.all(np.isfinite(values)):
        words = "a vector of three finite numbers" if shape == (3,) else f"finite numbers of shape {shape}"
        raise ValueError(f"{name} must be {words} [{unit}], found {values.tolist()}")
    return values


def real_vector(values, name, unit):
    """Real array (3,)."""
    values = numbers_of(values, name, (3,), unit)
    if np.iscomplexobj(values):
        raise ValueError(f"{name} must be real, found {values.tolist()}")
    return values.astype(np.float64)


def need_name(name):
    """The name of a load pattern is that of a dataset."""
    if not isinstance(name, str) or not name or "/" in name or name in (".", ".."):
        raise ValueError(f"the name of a load pattern must be a text without a slash, found {name!r}")


def with_phase(values, phase, name):
    """Pattern name to values and course, of values that come `phase` [rad] later than the cosine."""
    if np.ndim(phase) or np.asarray(phase).dtype.kind not in "iuf" or not np.isfinite(phase):
        raise ValueError(f"phase must be a finite number [rad], found {phase!r}; nodes with phases of their own take a call each")
    values = np.asarray(values) * np.exp(-1j * phase) if phase else np.asarray(values)
    parts = {name: (values.real.astype(float), FORTH), name + LATER: (-values.imag.astype(float), LATE)}
    rounding = 4 * np.finfo(float).eps * np.abs(values).max(initial=0)  # of a phase of 90 degrees
    there = {part: load for part, load in parts.items() if np.abs(load[0]).max(initial=0) > rounding}
    return there or {name: parts[name]}


def of_moment(points, moment, said):
    """Forces (k, 3) at points that make the moment (3,) and no force: the smallest such ones, w x (p - mean of p)."""
    if np.iscomplexobj(moment):
        return of_moment(points, moment.real, said) + 1j * of_moment(points, moment.imag, said)
    arms = points - points.mean(axis=0)
    inertia = np.sum(arms * arms) * np.eye(3) - arms.T @ arms
    turning = np.linalg.lstsq(inertia, moment, rcond=1e-12)[0]
    if np.linalg.norm(inertia @ turning - moment) > 1e-9 * np.linalg.norm(moment):
        raise ValueError(f"forces on {said} cannot make the moment {np.asarray(moment).tolist()}: all nodes lie on a line along it, or "
                         "there is only one; name a set with nodes beside it")
    return np.cross(turning, arms)


def pressure_series(pressure, nodes, course):
    """Columns [p0, a1, b1, ...] of the pressure at each node (m, 2H+1), which all nodes share where there is a `course`."""
    pressure = np.asarray(pressure)
    if np.iscomplexobj(pressure):
        raise ValueError("a complex pressure is a cosine with a phase; a series, of all nodes or of each, is real")
    if pressure.ndim < 2:
        course = numbers_of(course, "fourier", (np.size(course),), "-")
        if not course.size:
            raise ValueError("fourier must have a coefficient at least, found []")
        pressure = numbers_of(np.broadcast_to(pressure, (nodes,)) if pressure.ndim == 0 else pressure, "pressure", (nodes,), "Pa")
        return np.outer(pressure, course)
    if course is not None:
        raise ValueError("pressure has a series for each node already; leave `fourier` out")
    return numbers_of(pressure, "pressure", (nodes, pressure.shape[1]), "Pa")


def series_name(name, place):
    """Pattern of coefficient `place` of [p0, a1, b1, ...]."""
    return f"{name}_{'b' if place % 2 == 0 else 'a'}{(place + 1) // 2}"


def translation(structure, vector):
    """The rigid motion (n,) of all nodes by a vector (3,)."""
    r = np.zeros(structure.n)
    moves = (structure.dof_node >= 0) & (structure.dof_direction >= 0) & (structure.dof_direction < 3)
    r[moves] = np.asarray(vector)[structure.dof_direction[moves]]
    return r


def times(matrix, r):
    """matrix r, as an array (n,), or as a Vec where the matrix is PETSc's."""
    if not is_petsc(matrix):
        return matrix @ r
    x, y = matrix.createVecs()
    x.setArray(r[slice(*x.getOwnershipRange())])
    matrix.mult(x, y)
    return y


def need_free(structure, r, what):
    """Refuses a rigid motion that some support holds: K r = 0 must be true."""
    K = structure.K
    if is_petsc(K):
        held, sizes = times(K, r).norm(3), _absolute(K, r).norm(3)  # largest entry
    else:
        held, sizes = np.abs(K @ r).max(initial=0), (abs(K) @ np.abs(r)).max(initial=0)
    if held > RIGID * sizes:
        raise ValueError(f"{what} needs all that holds the structure to move along, but K r is {held:.3g} where {RIGID * sizes:.3g} "
                         "would be rounding, r being the motion with the base: call it before `clamped`, which names the base; "
                         "springs to the ground, or nodes fixed in the imported matrices, cannot move along")


def _absolute(K, r):
    begin, end = K.getOwnershipRange()
    indptr, indices, data = K.getValuesCSR()
    sums = np.add.reduceat(np.append(np.abs(data * r[indices]), 0.0), indptr[:-1]) if len(data) else np.zeros(end - begin)
    y = K.createVecLeft()
    y.setArray(np.where(np.diff(indptr) > 0, sums, 0.0))
    return y


def excitation(courses):
    """The [[excitation.load]] entries of a case file, as text: pattern name to series [a0, a1, b1, ...]."""
    return "\n".join(f"[[excitation.load]]\npattern = \"{name}\"\nfourier = [{', '.join(f'{value:g}' for value in course)}]\n"
                     for name, course in courses.items())
