"""Numbers that a user gives to a function: what cannot be meant is refused with its name."""

import numpy as np


def whole_number(value, name, low, high=None):
    """A whole number, from `low` to `high`."""
    if np.ndim(value) or not _within(np.asarray(value), low, high):
        raise ValueError(f"{name} must be a whole number from {_range(low, high)}, found {value!r}")
    return int(value)


def whole_numbers(values, name, low, high=None):
    """(k,) whole numbers, each from `low` to `high`."""
    found = np.asarray(values)
    if found.size and (found.ndim != 1 or not _within(found, low, high)):
        raise ValueError(f"{name} must be a list of whole numbers from {_range(low, high)}, found {values!r}")
    return found.ravel().astype(np.int64)


def finite_number(value, name):
    """A number that is finite."""
    return float(_finite(value, name, 0, "one finite number"))


def finite_numbers(values, name):
    """(N,) numbers that are finite."""
    return _finite(values, name, 1, "a list of finite numbers")


def _finite(values, name, axes, wanted):
    found = np.asarray(values)
    if found.dtype.kind not in "iuf" or found.ndim != axes or not np.isfinite(found).all():
        raise ValueError(f"{name} must be {wanted}, found {values!r}")
    return found.astype(np.float64)


def _within(found, low, high):
    return found.dtype.kind in "iu" and found.min() >= low and (high is None or found.max() <= high)


def _range(low, high):
    return f"{low} on" if high is None else f"{low} to {high}"
