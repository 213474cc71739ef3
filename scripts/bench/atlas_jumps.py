"""Silent jumps: steps of a curve that lead to another branch without a word.

A curve is looked at in coordinates without units: modal and contact coefficients over their largest norm on the curve, the frequency over
the width of the sweep. A step from one point to the next is suspect if

- it is `LONG` times as long as both its neighbours, or
- it points away, by more than `AWAY`, from both the step before and the step after: a corner of the curve turns off from one of them only.

A suspect step is put to the test: the curve is followed again, from points before, with much finer steps. If that comes by the first point
and then by the second, within `NEAR` of the step's length and no later than `LOOP` of these lengths, or `BEYOND` of the neighbours', there
was no jump. If it comes by the second later, the step cut off a loop of the curve, which counts as a jump. So does a curve that comes by
the first point and goes on, not back, for `BEYOND` steps as long as the neighbours without coming by the second. As finer steps may go
astray as well, several curves are followed, and one that finds no jump clears the step. If none says anything, or their steps there are no
finer than `NEAR` of the step, it stays in doubt.
Steps a method has announced are no jumps. Places located within a step make pieces of it as short as they like: neighbours count whole.
"""

import numpy as np

LONG = 3.0
AWAY = np.radians(50)
FINER = 20
NEAR = 0.25
LOOP = 5
BEYOND = 5
MOST_SUSPECTS = 5  # put to the test, the worst first
SHORTEST = 1e-6  # of a sweep: shorter steps than that jump nowhere


def coordinates(omega, coefficients, modes, width):
    """(points, unknowns + 1) without units."""
    parts = [coefficients[:, :modes].reshape(len(omega), -1), coefficients[:, modes:].reshape(len(omega), -1)]
    largest = [np.linalg.norm(part, axis=1).max(initial=0) or 1 for part in parts]
    return np.column_stack([part / size for part, size in zip(parts, largest)] + [omega / width])


def joined(one, other):
    """Coefficients (points, n, 2H+1) of two curves, one after the other; where one has fewer harmonics the rest is zero."""
    width = max(one.shape[2], other.shape[2])
    return np.concatenate([np.pad(part, ((0, 0), (0, 0), (0, width - part.shape[2]))) for part in (one, other)])


def apart(z):
    """Points that do not lie where the one before lies: a place that is two things at once, say a corner where stability is lost, is
    stored twice, and a step of no length says nothing of its neighbours."""
    kept = [0]
    for i in range(1, len(z)):
        if np.linalg.norm(z[i] - z[kept[-1]]) >= SHORTEST:
            kept.append(i)
    return np.array(kept)


def suspects(z, announced=(), places=()):
    """Steps or pieces of steps (index of the point they start from) that may be jumps, the worst first. places : located within steps"""
    steps = np.diff(z, axis=0)
    length = np.linalg.norm(steps, axis=1)
    said = {point - 1 for point in announced}
    ends = np.setdiff1d(np.arange(len(z)), places)
    of = np.searchsorted(ends, np.arange(len(steps)), "right")  # number of the step that a piece belongs to
    whole = np.bincount(of, length, of[-1] + 2)
    found = {}
    for i in range(1, len(steps) - 1):
        if i in said or length[i] < SHORTEST:
            continue
        ratio = length[i] / max(whole[of[i] - 1], whole[of[i] + 1], 1e-300)
        cosine = [steps[i] @ steps[j] / (length[i] * max(length[j], 1e-300)) for j in (i - 1, i + 1)]
        if ratio > LONG and not {i - 1, i + 1} & said or max(cosine) < np.cos(AWAY):
            found[i] = length[i]
    return sorted(found, key=found.get, reverse=True)


def passed(curve, place):
    """Distances of a place from each piece of a polyline (points, n), and the lengths along it to where it is nearest to each."""
    along = np.diff(curve, axis=0)
    lengths = np.linalg.norm(along, axis=1)
    part = np.clip(np.sum((place - curve[:-1]) * along, axis=1) / np.maximum(lengths ** 2, 1e-300), 0, 1)
    distance = np.linalg.norm(curve[:-1] + part[:, None] * along - place, axis=1)
    return distance, np.cumsum(lengths) - lengths + part * lengths


def nearest(curve, place):
    """Distance of a polyline (points, n) from a place, and the length along it to where it is nearest."""
    distance, where = passed(curve, place)
    i = np.argmin(distance)
    return distance[i], where[i]


def verdict(curve, before, first, second, beyond):
    """What a curve that was followed again says about the step from `first` to `second`: "no jump", "jump", or None.

    before : the point before the first;  beyond : how far it has to go on from `first`
    """
    step = np.linalg.norm(second - first)
    if len(curve) < 2:
        return None
    off, begins = nearest(curve, first)
    if off > NEAR * step:
        return None
    distance, where = passed(curve, second)
    comes = where[(distance < NEAR * step) & (where >= begins)]
    if len(comes):
        return "no jump" if comes[0] - begins < max(LOOP * step, beyond) else "jump"
    lengths = np.linalg.norm(np.diff(curve, axis=0), axis=1)
    ends = np.cumsum(lengths)
    coarse = lengths[(ends > begins) & (ends - lengths < begins + step)].max(initial=0) > NEAR * step
    back, where = nearest(curve, before)
    goes_back = where > begins and back < NEAR * np.linalg.norm(first - before)
    return "jump" if ends[-1] - begins > min(beyond, 1.5 * step) and not goes_back and not coarse else None


def silent_jumps(omega, coefficients, modes, width, announced, follow, all_of_them=True, places=()):
    """Steps proved to be silent jumps, and those that stay in doubt.

    places : points that no step led to, but were located within one

    follow(i, n) : iterates over curves (omega, coefficients) that may lead through points i and n, with fine steps;
    all_of_them : else no other step is looked at once a jump is proved
    """
    if len(omega) < 4:
        return [], []
    z = coordinates(omega, coefficients, modes, width)
    kept = apart(z)
    length = np.linalg.norm(np.diff(z[kept], axis=0), axis=1)
    jumps, doubts = [], []
    for k in suspects(z[kept], np.searchsorted(kept, announced), np.flatnonzero(np.isin(kept, places)))[:MOST_SUSPECTS]:
        said, i, n = set(), int(kept[k]), int(kept[k + 1])
        if np.linalg.norm(z[n] - z[n - 1]) < SHORTEST:
            continue  # several steps, none of them long enough
        for again in follow(i, n):
            if len(again[0]):
                both = coordinates(np.r_[omega, again[0]], joined(coefficients, again[1]), modes, width)
                said.add(verdict(both[len(omega):], *both[kept[k - 1:k + 2]], BEYOND * max(length[k - 1], length[k + 1])))
            if "no jump" in said:
                break
        else:
            (jumps if "jump" in said else doubts).append(i)
        if jumps and not all_of_them:
            break
    return jumps, doubts
