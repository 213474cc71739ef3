"""What contact points answer to small changes exp(lambda t) p(t) of a periodic motion, p a sum of waves exp(i k Omega t).

States of the motion are those of samples, and change in the middle between two. A slider that sticks remembers the instant since when it
does; one that never moves in the period answers with its spring.
"""

import numpy as np

from .reference import OPEN, contact, law, synthesis
from .slider_memory import SliderMemory, Stick

MANY = 1 << 15  # samples of a period: exponents are off by some 1e-5 of Omega
NOTHING = 1e-10  # of the motion: a foot that moves less from sample to sample rests; one that slides moves 1e-8 next to where it turns
OF_CONES = 128  # of points of law cone, which are dear: whether they stick all the time
AT_ONCE = 1 << 21  # samples of all contact points together that are in memory at a time


class KnownToTheProgram(ValueError):
    """Contacts whose answer to a small motion is not known here."""


class ContactWaves:
    """The contact points of a `HarmonicBalance` in the motion q: which states they are in, and since when."""

    def __init__(self, system, q):
        self.points, self.X = system.contact, system.contact_part(q)
        self.spans = [None] * self.points.points
        cones = self.points.kind == contact.CONE
        for which, samples in ((np.flatnonzero(cones), OF_CONES), (np.flatnonzero(~cones), MANY)):
            for part in np.array_split(which, -(-len(which) * samples // AT_ONCE) or 1):
                for point, state in zip(part, self._states(part, samples, system.preload)):
                    self.spans[point] = [spans(state[:, t]) for t in range(2)]
        for point in np.flatnonzero(cones):
            if [value for one in self.spans[point] for value, *_ in one] not in ([0, 0], [OPEN, OPEN]):
                raise KnownToTheProgram(f'contact point {point + 1} of law "cone" slips, or opens and closes: how it answers is '
                                        "known to the program alone; ask with --whole")

    def _states(self, part, samples, preload):
        points = self.points
        x = np.swapaxes(synthesis(self.X[part], samples), -1, -2)
        force, states = law(x, preload.xp[part], preload.w[part], points.kn[part], points.kt[part], points.mu[part], points.gap[part],
                            points.kind[part])
        foot = x[..., :2] - force[..., :2] / np.where(points.kt[part] > 0, points.kt[part], 1)[:, None]
        still = np.abs(foot - np.roll(foot, 1, axis=1)) < NOTHING * np.ptp(x[..., :2], axis=1, keepdims=True)
        return np.where(still & (states != OPEN), 0, states)  # sliders that only just reach their bound

    @property
    def springs(self):
        """(N_x, 3) of t1, t2, n; 0 without friction."""
        return np.column_stack([np.where((self.points.kind <= contact.CONE)[:, None], self.points.kt, 0), self.points.kn])

    def sticks(self):
        """Stick of all sliders that do not stick all the time."""
        out = []
        for point, one in enumerate(self.spans):
            kn, kt, mu = self.points.kn[point], self.springs[point, :2], self.points.mu[point]
            for t in np.flatnonzero(kt):
                for value, begin, end, before in one[t]:
                    if value == 0 and before is not None:
                        by_n = slope(self.X[point], t, begin) if before == OPEN else before * mu[t] * kn / kt[t]
                        out.append(Stick(point, t, begin, end, kt[t], -by_n))
        return out

    def answers(self, k, shift):
        """Amplitudes of the forces of waves k (w,) by motions of these waves, (N_x, 3, w, 3, w) complex, for lambda / Omega = shift;
        and the SliderMemory for others.
        """
        out = np.zeros((self.points.points, 3, len(k), 3, len(k)), complex)
        apart = k[:, None] - k
        for point, one in enumerate(self.spans):
            kn, kt, mu = self.points.kn[point], self.springs[point, :2], self.points.mu[point]
            out[point, 2, :, 2] = kn * sum(integral(apart, begin, end) for value, begin, end, _ in one[0] if value != OPEN)
            for t in np.flatnonzero(kt):
                for value, begin, end, _ in one[t]:
                    if value in (1, -1):
                        out[point, t, :, 2] += value * mu[t] * kn * integral(apart, begin, end)
                    elif value != OPEN:
                        out[point, t, :, t] += kt[t] * integral(apart, begin, end)
        memory = SliderMemory(self.sticks(), k, shift)
        memory.add_to(out)
        return out, memory


def spans(values):
    """(value, begin, end, value before) of the parts of a period [rad] with one value; of a single one that before it is None."""
    first = np.flatnonzero(values != np.roll(values, 1))
    if not len(first):
        return [(int(values[0]), 0.0, 2 * np.pi, None)]
    step, ends = 2 * np.pi / len(values), np.append(first[1:], first[0] + len(values))
    return [(int(values[i]), (i - 0.5) * step, (j - 0.5) * step, int(values[i - 1])) for i, j in zip(first, ends)]


def integral(k, begin, end):
    """That of exp(-i k theta) from begin to end, over 2 pi."""
    safe = np.where(k == 0, 1, k)
    return np.where(k == 0, end - begin, (np.exp(-1j * safe * end) - np.exp(-1j * safe * begin)) * 1j / safe) / (2 * np.pi)


def slope(X, t, angle):
    """Tangential over normal speed where a point lands; X (3, 2H+1)."""
    j = np.arange(1, X.shape[1] // 2 + 1)
    speed = (X[:, 2::2] * j) @ np.cos(j * angle) - (X[:, 1::2] * j) @ np.sin(j * angle)
    return speed[t] / speed[2]
