"""Points of a results file computed again, without the program: are they solutions, and does the energy balance?

All but the values of the contact points, which are those of the results file, follows from the case's text and the reduced file by
the NumPy reference. A point passes where
  - what is missing of the equations (11), at the samples of the run, of exact forces at MANY, is what the file says of it, and that
    is within the tolerance of Newton's method;
  - work put in = damped + rubbed, where the rubbed work is summed along the ways of the sliders, at MANY samples;
  - the energy that the file says each contact dissipates is that sum.
"""

from dataclasses import dataclass

import numpy as np

from . import reference
from .hdf5_read import opened
from .recovery import reduced_file
from .reduced_system import equations, reduced_of
from .reference.reduction import static_force
from .results import Results
from .study_runs import RunFailed
from .units import bracket
from .verify_bounds import LAST_BITS, between_samples, last_bits, newton_tolerance, residual_told, scaled_forces
from .verify_curve import estimates_judged, peaks_judged

MANY = 65536  # samples of a period; sampled forces converge as 1/N^2
OF_CONES = 512  # of the law cone, whose steps are exact, and dear
AT_ONCE = 1 << 21  # samples of all contact points together that are in memory at a time
PRELOAD = 1e-9  # of the forces at rest, ten times what the preload's Newton method leaves
PER_TOLERANCE = 1.5  # what may be found of a residual that is told: numbers are written and added up in another order
NOT_JUDGED = ("not judged: stability, whether the curve has other branches, whether the contact values in the file "
              "are those of the case, and how well the reduced model stands for the structure")


@dataclass(frozen=True)
class Forces:
    """What contact points do in a period, N samples: G (N_x, 3, 2H+1) coefficients of g(x + xp) - g(xp), rubbed (N_x,) work."""

    G: np.ndarray
    rubbed: np.ndarray


@dataclass(frozen=True)
class Verdict:
    """Of one point: numbers found and their bounds. Residuals are relative to the load, energies to the work put in.

    residual, residual_bound : of the modes or of the contact points, whichever is nearer to its bound
    told, tolerance : what the file says that Newton's method has left, and what the case or last bits allow, in scaled variables
    sampling : residual with MANY samples, of a run that took fewer, else None
    work, damped, rubbed : energy of a period [J]
    energy, stored : how far the balance is off, and the energy of the file from `rubbed`
    """

    point: int
    residual: float
    residual_bound: float
    told: float
    tolerance: float
    sampling: float | None
    work: float
    damped: float
    rubbed: float
    energy: float
    energy_bound: float
    stored: float

    @property
    def complaints(self):
        found = []
        if not self.residual <= self.residual_bound:
            found.append(f"the residual is {self.residual:.1e} of the load, {self.residual_bound:.1e} allowed")
        if not self.told <= self.tolerance:
            found.append(f"/points/residual is {self.told:.1e}, {self.tolerance:.1e} allowed")
        if not self.energy <= self.energy_bound:
            found.append(f"the energy is off by {self.energy:.1e} of the work put in, {self.energy_bound:.1e} allowed")
        if not self.stored <= self.energy_bound:
            found.append(f"/points/contact/dissipation is off by {self.stored:.1e} of the work put in, {self.energy_bound:.1e} allowed")
        return found


def sampled_forces(system, q, samples, of_cones):
    """`Forces` of the contacts of a `HarmonicBalance` in the motion q; `samples` of a period, those of the law cone `of_cones`."""
    X, G, rubbed = system.contact_part(q), np.zeros_like(system.contact_part(q)), np.zeros(system.contact.points)
    cones = system.contact.kind == reference.contact.CONE
    for which, n in ((np.flatnonzero(~cones), samples), (np.flatnonzero(cones), of_cones)):
        for part in np.array_split(which, -(-len(which) * n // AT_ONCE) or 1):
            G[part], rubbed[part] = _period(system, X, part, n)
    return Forces(G, rubbed)


def _period(system, X, rows, samples):
    contact, preload = system.contact, system.preload
    kt, kind = contact.kt[rows], contact.kind[rows]
    x = np.swapaxes(reference.synthesis(X[rows], samples), -1, -2)
    force, _ = reference.law(x, preload.xp[rows], preload.w[rows], contact.kn[rows], kt, contact.mu[rows], contact.gap[rows], kind)
    T = force[..., :2]
    foot = x[..., :2] - T / np.where(kt > 0, kt, 1)[:, None]
    way = foot - np.roll(foot, 1, axis=1)
    rubbed = np.sum((T + np.roll(T, 1, axis=1)) / 2 * way, axis=(1, 2)) * (kind <= reference.contact.CONE)
    return reference.analysis(np.swapaxes(force - preload.g[rows, None], -1, -2), system.H), rubbed


def work(force, q):
    """Energy [J] of a period that forces put into a motion, both coefficients (n, 2H+1)."""
    k = np.arange(1, q.shape[1] // 2 + 1)
    return np.pi * np.sum(k * (force[:, 1::2] * q[:, 2::2] - force[:, 2::2] * q[:, 1::2]))


def verdict(results, point, samples=MANY):
    """The `Verdict` of a point."""
    i = results.number(point)
    system = equations(results, samples, None if results.modal_amplitude is not None or results.parameter is None
                       else results.parameter[i])
    q, omega, modes = results.coefficients_at(i), results.omega[i], results.modes
    q[modes:, 0] += 2 * (results.xp - system.preload.xp.ravel())
    width = 2 * int(results.points("harmonics")[i]) + 1  # of a run that adds harmonics, those of this point
    load, fed = system.excitation, np.zeros_like(q)
    if results.modal_amplitude is not None:  # the load but for its mean is away, and negative damping feeds the motion
        load, zeta = np.where(np.arange(q.shape[1]) == 0, load, 0.0), results.damping_ratio[i]
        fed = system.times(lambda k: 2j * k * zeta * omega**2 * system.matrices(k)[1], q)
    many, fewer = (sampled_forces(system, q, samples // part, OF_CONES // part) for part in (1, 2))
    own, sampled = own_forces(system, q, results, width // 2, many.G)

    def missing(G):
        r = system.structure(q, omega) - load - fed
        r[modes:] += G.reshape(-1, q.shape[1])
        return r[:, :width]
    scale = [size_of(part, elastic) for part, elastic in zip(
        ((load[:modes],), (load[modes:], many.G)), np.split(system.times(lambda k: system.matrices(k)[0], q), [modes]))]

    def relative(r):
        return np.array([np.linalg.norm(part) / size if size > 0 else 0.0 for part, size in zip(np.split(r, [modes]), scale)])
    unit, rounding = np.array(scaled_forces(results, equations(results))), last_bits(system, q, omega)
    told = residual_told(results, i)
    tolerance = max(newton_tolerance(results), np.hypot(*[np.linalg.norm(part) for part in np.split(rounding, [modes])] / unit))
    by_newton = PER_TOLERANCE * min(told, tolerance) * unit
    by_law = np.concatenate([np.zeros(modes), between_samples(system, q, samples, sampled, many.G).ravel()])
    by_samples = amplitudes(own - many.G) + amplitudes(many.G - fewer.G)
    per_size = np.array([1 / size if size > 0 else 0.0 for size in scale])
    bound = by_newton * per_size + relative(by_law) + relative(rounding)
    found = relative(missing(own))
    worst = int(np.argmax(np.where(found > 0, found, 0) / np.where(bound > 0, bound, 1)))

    put_in, damped, rubbed = work(load + fed, q), work(system.times(lambda k: system.damper(k, omega), q), q), many.rubbed.sum()
    most = max(abs(put_in), abs(damped) + abs(rubbed))
    sizes = [amplitudes(part) for part in np.split(q, [modes])]
    open_energy = np.pi * np.arange(1, system.H + 1) @ (sum(allowed * size * norm for allowed, size, norm in zip(bound, scale, sizes))
                                                        + by_samples * sizes[1]) + abs(rubbed - fewer.rubbed.sum())
    stored = abs(results.contact_activity(i).dissipation.sum() - rubbed) if results.has_activity and len(many.rubbed) else 0.0
    per_work = 1 / most if most > 0 else 0.0
    return Verdict(i, found[worst], bound[worst], told, tolerance, relative(missing(many.G)).max() if sampled.any() else None, put_in,
                   damped, rubbed, abs(put_in - damped - rubbed) * per_work, open_energy * per_work, stored * per_work)


def amplitudes(values):
    """Size of each harmonic k >= 1 of coefficients (..., 2H+1), both columns of all rows together, whatever the phase: (H,)."""
    size = np.linalg.norm(values.reshape(-1, values.shape[-1]), axis=0)
    return np.hypot(size[1::2], size[2::2])


def own_forces(system, q, results, harmonics, exact):
    """`Forces.G` at the samples that the run took, and (N_x,) whether it took any: of cones always, of others as the case says."""
    sampled = np.full(system.contact.points, bool(results.samples)) | (system.contact.kind == reference.contact.CONE)
    samples = results.samples or max(256, 1 << (40 * harmonics - 1).bit_length())
    G = exact.copy()
    if sampled.any():
        rows = np.flatnonzero(sampled)
        G[rows], _ = _period(system, system.contact_part(q), rows, samples)
    return G, sampled


def size_of(parts, elastic):
    """What a residual of some rows is relative to: their load, or the elastic forces where nothing loads them."""
    size = sum(map(np.linalg.norm, parts))
    return size if size > 0 else np.linalg.norm(elastic)


def looked_at(results, points):
    """Numbers of so many points, evenly over the curve: from 2 on its ends, from 3 on its largest among them, then its located peaks,
    as many as fit in half of them."""
    n = len(results)
    chosen = {int(i) for i in np.linspace(0, n - 1, min(points, n)).round()}
    wanted = [results.largest_point(results.watched), *results.events.of("peak").point[:points // 2 - 1]] if points > 2 else []
    for point in wanted:
        others = chosen - {0, n - 1, *wanted}
        if point not in chosen and others:
            chosen = chosen - {min(others, key=lambda i: abs(i - point))} | {int(point)}
    return sorted(chosen)


def preload_complaint(results):
    """Whether the preload state is none: words, or "" where eq (7) and the law of contact hold. Of the case, not of a path's values."""
    system = equations(results)
    x = system.preload.xp
    with opened(reduced_file(results)) as file:
        r = reduced_of(file, results)[0].r
    stiffness = system.K[results.modes:, results.modes:]
    missing = stiffness @ x.ravel() + system.preload.g.ravel() + r
    size = max(np.linalg.norm(r), np.linalg.norm(system.preload.g))
    bound = PRELOAD * size + LAST_BITS * np.finfo(float).eps * np.linalg.norm(np.abs(stiffness) @ np.abs(x.ravel()))
    law = static_force(x, system.contact)[0] - system.preload.g
    off = max(np.linalg.norm(missing), np.linalg.norm(law))
    return f"preload: forces are off by {off / size:.1e} of the load, {bound / size:.1e} allowed" if off > bound else ""


def verify(arguments):
    """The command. Raises RunFailed where a point does not hold."""
    results = Results(arguments.file, arguments.model)
    results.need_points()
    if arguments.points < 1:
        raise ValueError(f"--points {arguments.points}: must be at least 1")
    own = "exact" if results.samples == 0 else f"at {results.samples} samples"
    print(f"{results.path}: {len(results)} points, forces {own}; recomputed at {MANY} samples of a period, of the law cone at {OF_CONES}")
    failed = [complaint] if (complaint := preload_complaint(results)) else []
    print(complaint or "preload: in equilibrium")
    print(" " * 29 + "residual / load" + " " * 17 + "energy of a period" + bracket(results.unit.energy))
    print(f"{'point':>6} {results.parameter_name or 'omega':>16} {'own':>9} {'allowed':>9} {f'at {MANY}':>9} {'put in':>12} "
          f"{'damped':>12} {'rubbed':>12} {'off by':>9} {'allowed':>9}  verdict")
    verdicts = []
    for point in looked_at(results, arguments.points):
        one = verdict(results, point, MANY)
        sampling = "" if one.sampling is None else f"{one.sampling:.1e}"
        print(f"{point:6d} {results.along[point]:16.9g} {one.residual:9.1e} {one.residual_bound:9.1e} {sampling:>9} {one.work:12.4e} "
              f"{one.damped:12.4e} {one.rubbed:12.4e} {one.energy:9.1e} {one.energy_bound:9.1e}  "
              f"{'FAILS' if one.complaints else 'holds'}", flush=True)
        failed += [f"point {point}: {complaint}" for complaint in one.complaints]
        verdicts.append(one)
    for words, complaints in (peaks_judged(results), estimates_judged(results)):
        print(words)
        failed += complaints
    print(NOT_JUDGED)
    if failed:
        raise RunFailed(f"{results.path}: does not hold: " + "; ".join(failed))
    print(summed_up(verdicts, len(results)))


def summed_up(verdicts, n):
    """A sentence on verdicts that all hold, of n points. Where nothing dissipates, work is made of rounding errors, and says nothing."""
    residual = max(verdicts, key=lambda one: one.residual)
    energy = max((one for one in verdicts if one.energy_bound < 1), key=lambda one: one.energy, default=None)
    return (f"verified: {len(verdicts)} of {n} points; the largest residual is {residual.residual:.1e} of the load, at point "
            f"{residual.point}, and " +
            (f"energy balances to {energy.energy:.1e}, at point {energy.point}" if energy else "there is no energy to balance"))
