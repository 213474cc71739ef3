"""The three methods the atlas compares, each run on a built scene: the original, plain adaptive continuation, Dovetail.

A run is a `Run`: how it ended, what it cost, and its curve. Seconds are limited, of the processor so that other work on the machine does
not decide; a run that reaches the limit keeps its points.
"""

import json
import os
import resource
import signal
import subprocess
import time
from dataclasses import dataclass

import numpy as np
from measure import BINARY

from dovetail import Results, reference

ORIGINAL, PLAIN, DOVETAIL = METHODS = ("original", "plain", "dovetail")
SAMPLES = 64  # N of the first two, as delivered
ALONE = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "OMPI_MCA_ess_singleton_isolated": "1"}  # one thread, no MPI daemon
BEHIND = 0.5  # a curve that comes this far behind the beginning, in sweeps, has turned back
MOST_POINTS = 10000  # the original's own limit


@dataclass
class Run:
    """end : "arrived", "no start", "stopped" (at its last point), "turned back", "limit" (of seconds or points), "crashed"

    sweep : (from, to) [rad/s];  newton : iterations;  seconds : of the processor;  said : its own words
    omega (points,), coefficients (points, N_a + 3 N_x, 2H+1) : the curve, user units
    announced : steps (number of the point they lead to) of which the method says that they leave the curve, leave points of it out, or
        solve other equations from there on
    """

    end: str
    sweep: tuple
    newton: int
    seconds: float
    said: str
    omega: np.ndarray
    coefficients: np.ndarray
    announced: tuple = ()

    @property
    def points(self):
        return len(self.omega)

    def figures(self):
        """All but the curve, for JSON."""
        first, last = self.sweep
        reached = (self.omega[-1] - first) / (last - first) if self.points else 0.0
        return dict(end=self.end, points=self.points, newton=self.newton, seconds=round(self.seconds, 3), said=self.said,
                    reached=round(float(reached), 6), announced=len(self.announced))


def left_out(omega, leaps, sweep):
    """Part of a sweep that the curve does not pass: at its ends, or in between, under leaps (numbers of the points they lead to)."""
    low, high = sorted(sweep)
    steps = [sorted(omega[i - 1:i + 1]) for i in range(1, len(omega)) if i not in leaps]
    missing, reached = 0.0, low
    for a, b in sorted(steps) + [[high, high]]:
        missing += max(0.0, min(a, high) - reached)
        reached = max(reached, min(b, high))
    return missing / (high - low)


class Plain(reference.HarmonicBalance):
    """`HarmonicBalance` with its contact forces evaluated faster, and its Jacobians counted.

    The same law and the same samples: a slider's foot moves to w = min(max(w, low), high), where low, high = x_t -+ mu N / kt,
    both x_t while open, and both the same where a contact lands, as the foot does not matter there.
    """

    jacobians = 0

    def forces(self, X):
        """`reference.contact_coefficients` for coefficients X (..., N_x, 3, 2H+1), complex ones included."""
        c, p = self.contact, self.preload
        x = reference.synthesis(X, self.N) + p.xp[..., None]
        approach = np.moveaxis(x[..., 2, :] - c.gap[:, None], -1, 0)[..., None]  # samples first
        surface = np.moveaxis(x[..., :2, :], -1, 0)
        closed = approach.real > 0
        normal = np.where(closed, c.kn[:, None] * approach, 0)
        landing = closed & ~np.roll(closed, 1, axis=0)
        before, p_before = np.roll(surface, 1, axis=0), np.roll(approach, 1, axis=0)
        touch = before + p_before / np.where(landing, p_before - approach, 1) * (surface - before)
        reach = normal * (c.mu / c.kt)
        low, high = surface - reach, surface + reach
        touch = np.where(touch.real < low.real, low, np.where(touch.real > high.real, high, touch))
        low, high = np.where(landing, touch, low), np.where(landing, touch, high)
        w, feet = np.broadcast_to(p.w, low.shape[1:]), np.empty_like(low)
        for j in 2 * list(range(self.N)):
            w = np.minimum(np.maximum(w, low[j], out=feet[j]), high[j], out=feet[j])  # complex ones: by their real parts first
        tangential = np.where(closed, c.kt * (surface - feet), 0)
        force = np.concatenate([np.moveaxis(tangential, 0, -1), np.moveaxis(normal, 0, -1)], axis=-2)
        return reference.analysis(force - p.g[..., None], self.H)

    def residual(self, q, omega):
        r = (self.dynamic_stiffness(omega) @ q.ravel()).reshape(self.shape) - self.excitation
        r[self.modes:] += self.forces(self.contact_part(q)).reshape(-1, self.shape[1])
        return r

    def jacobian(self, q, omega):
        self.jacobians += 1
        n, size = self.shape
        h = 1e-30
        matrix = self.dynamic_stiffness(omega).reshape(n, size, n, size)
        moved = self.contact_part(q) + 1j * h * np.eye(3 * size).reshape(3 * size, 1, 3, size)
        columns = self.forces(moved).imag / h
        for point in range(self.contact.points):
            rows = slice(self.modes + 3 * point, self.modes + 3 * point + 3)
            matrix[rows, :, rows, :] += np.moveaxis(columns[:, point].reshape(3, size, 3, size), (0, 1), (2, 3))
        return matrix.reshape(n * size, n * size)


def arguments(built, harmonics=None, samples=None):
    """What `reference.HarmonicBalance` and its like want of a scene."""
    H = harmonics or built.delivered
    preload = reference.contact_preload(built.reduced, built.contact, built.initial)
    return built.reduced, built.contact, preload, built.xi, built.fourier, H, samples or max(SAMPLES, 4 * H)


def original(built, limit):
    """The original's algorithm as delivered: fixed arc length, no scaling."""
    return collect(lambda: with_count(reference.Original(*arguments(built)).branch(*built.omega, built.arc)), built, limit)


def with_count(branch):
    newton = 0
    for omega, q, iterations in branch:
        newton += iterations
        yield omega, q, newton


def plain(built, limit):
    """`reference.HarmonicBalance.continuation`: adaptive arc length, exact Jacobian, line search, the same equations each time."""
    def counted():
        system = Plain(*arguments(built))
        for tangents, (omega, q) in enumerate(system.branch(*built.omega, built.arc)):
            yield omega, q, system.jacobians - tangents  # one Jacobian of each point is for its tangent

    return collect(counted, built, limit)


def collect(branch, built, limit):
    """Run a generator of (omega, q, Newton iterations so far) to its end, its failure or the limit of seconds."""
    start, done, end, said = time.process_time(), [], "arrived", ""
    first, last = built.omega
    try:
        for point in branch():
            done.append(point)
            if (point[0] - first) / (last - first) < -BEHIND:
                end = "turned back"
                break
            if time.process_time() - start > limit or len(done) == MOST_POINTS:
                end = "arrived" if point[0] == last else "limit"
                break
    except (RuntimeError, np.linalg.LinAlgError, FloatingPointError) as stopped:
        end, said = "stopped" if done else "no start", str(stopped)
    omega, q, newton = zip(*done) if done else ((), (), (0,))
    return Run(end, built.omega, newton[-1], time.process_time() - start, said, np.array(omega), np.array(q))


@dataclass
class Limited:
    """A finished command. status : exit status, None if it took too long."""

    status: int
    output: str
    complaint: str
    seconds: float


def limited(command, seconds, patience=30):
    """Run a command that may take `seconds` of the processor, and `patience` times as long on the clock."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    whole = int(np.ceil(seconds))
    try:
        done = subprocess.run([str(word) for word in command], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                              timeout=patience * seconds, env={**os.environ, **ALONE},
                              preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_CPU, (whole, whole + 1)))
        status, output, complaint = done.returncode, done.stdout, done.stderr
    except subprocess.TimeoutExpired as stopped:
        status, output, complaint = None, (stopped.stdout or b"").decode(), ""
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    used = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    ended = used >= whole or status in (-signal.SIGXCPU, -signal.SIGKILL)
    return Limited(None if ended else status, output, complaint, used)


ENDS = {"arrived": "arrived", "no_start": "no start", "turned_back": "turned back", "retraced": "turned back", "max_points": "limit",
        "stalled": "stopped"}


def dovetail(case, sweep, folder, limit, binary=BINARY):
    """`dovetail run` on a case, results in `folder`: the run, and its summary.json."""
    for name in ("results.h5", "summary.json"):
        (folder / name).unlink(missing_ok=True)
    run = limited([binary, "run", case, "--out", folder], limit)
    summary = folder / "summary.json"
    about = json.loads(summary.read_text()) if summary.exists() else {}
    omega, coefficients, announced, newton, leaps = np.array([]), np.array([]), (), 0, ()
    if (folder / "results.h5").exists():
        results = Results(folder / "results.h5")
        omega, coefficients = results.omega, results.coefficients
        newton = int(results.points("newton_iterations").sum())
        announced = tuple(int(i) + 1 for i in results.events.of("leap", "integration", "outside", "harmonics").point)
        about["places"] = np.flatnonzero(results.points("located")).tolist()
        leaps = [int(i) + 1 for i in results.events.of("leap", "integration").point]
    about["left_out"] = round(left_out(omega, leaps, sweep), 4)
    end = "limit" if run.status is None else ENDS.get(about.get("end"), "crashed") if run.status in (0, 3) else "crashed"
    said = run.complaint.strip().splitlines()
    return Run(end, sweep, about.get("newton_iterations", newton), run.seconds, said[-1] if said else "", omega, coefficients,
               announced), about
