"""Points that fill a cube evenly."""

import math


def sobol(dimensions, count, seed):
    """`count` points of Sobol's sequence within -1..1, as (count, dimensions); the first ones are the same for any count."""
    from scipy.stats import qmc  # takes as long to load as all else together

    return 2 * qmc.Sobol(dimensions, seed=seed).random_base2(math.ceil(math.log2(count)))[:count] - 1
