"""What contact points answer to small changes of a periodic motion that are sums of waves exp(i k Omega t), k whole or half numbers.

States of the motion are those of samples, and change in the middle between two. Sliders are taken as in the program: what one that
sticks remembers is of the same instant, and one that never moves in the period answers with its spring.
"""

import numpy as np

from .reference import OPEN, contact, law, synthesis

MANY = 1 << 15  # samples of a period; exponents are off by some 1e-5 of Omega
NOTHING = 1e-10  # of the motion: by how much less the foot of a slider moves from sample to sample that rests
AT_ONCE = 1 << 21  # samples of all contact points together that are in memory at a time


def contact_blocks(system, q, k):
    """(N_x, 3, w, 3, w) complex: force amplitudes of the waves k (w,) by motions of these waves, about q of a `HarmonicBalance`."""
    X, points = system.contact_part(q), system.contact
    blocks = np.zeros((points.points, 3, len(k), 3, len(k)), complex)
    for part in np.array_split(np.arange(points.points), -(-points.points * MANY // AT_ONCE) or 1):
        x = np.swapaxes(synthesis(X[part], MANY), -1, -2)
        forces, states = law(x, system.preload.xp[part], system.preload.w[part], points.kn[part], points.kt[part], points.mu[part],
                             points.gap[part], points.kind[part])
        foot = x[..., :2] - forces[..., :2] / np.where(points.kt[part] > 0, points.kt[part], 1)[:, None]
        still = np.abs(foot - np.roll(foot, 1, axis=1)) < NOTHING * np.ptp(x[..., :2], axis=1, keepdims=True)
        states = np.where(still & (states != OPEN), 0, states)  # sliders that only just reach their bound
        for point, state in zip(part, states):
            _fill(blocks[point], state, X[point], points, point, k)
    return blocks


def _fill(block, state, X, points, point, k):
    kn, kt, mu = points.kn[point], points.kt[point], points.mu[point]
    apart = k[:, None] - k
    for value, begin, end, _ in spans(state[:, 0] == OPEN):
        block[2, :, 2] += 0 if value else kn * integral(apart, begin, end)
    if points.kind[point] > contact.CONE:
        return
    if points.kind[point] == contact.CONE and np.any((state != 0) & (state != OPEN)):
        raise ValueError(f"contact point {point + 1} of law \"cone\" slips: such points are judged by the program alone, --run")
    for t in range(2):
        for value, begin, end, before in spans(state[:, t]):
            if value == OPEN:
                continue
            if value != 0:
                block[t, :, 2] += value * mu[t] * kn * integral(apart, begin, end)
                continue
            block[t, :, t] += kt[t] * integral(apart, begin, end)
            if before is None:
                continue
            kept = np.outer(integral(k, begin, end), np.exp(1j * k * begin))
            block[t, :, t] -= kt[t] * kept
            block[t, :, 2] += (kt[t] * slope(X, t, begin) if before == OPEN else before * mu[t] * kn) * kept


def spans(values):
    """(value, begin, end, value before) of the parts of a period [rad] with one value; of a single one that before it is None."""
    first = np.flatnonzero(values != np.roll(values, 1))
    if not len(first):
        return [(values[0], 0.0, 2 * np.pi, None)]
    ends = np.append(first[1:], first[0] + len(values))
    step = 2 * np.pi / len(values)
    return [(values[i], (i - 0.5) * step, (j - 0.5) * step, values[i - 1]) for i, j in zip(first, ends)]


def integral(k, begin, end):
    """exp(-i k theta) from begin to end over 2 pi."""
    safe = np.where(k == 0, 1, k)
    return np.where(k == 0, end - begin, (np.exp(-1j * safe * end) - np.exp(-1j * safe * begin)) * 1j / safe) / (2 * np.pi)


def slope(X, t, angle):
    """By how much the tangential motion goes on per normal motion where a point lands; X (3, 2H+1)."""
    j = np.arange(1, X.shape[1] // 2 + 1)
    speed = (X[:, 2::2] * j) @ np.cos(j * angle) - (X[:, 1::2] * j) @ np.sin(j * angle)
    return speed[t] / speed[2]
