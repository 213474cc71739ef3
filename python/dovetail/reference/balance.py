"""Harmonic balance and continuation."""

from dataclasses import dataclass
from itertools import islice

import numpy as np
import scipy.linalg

from .contact import contact_coefficients, contact_jacobian
from .newton import newton


@dataclass(frozen=True)
class Damping:
    """stiffness b [s] and mass a [1/s] of b K + a M; structural eta, hysteretic, of K in all harmonics but the mean.

    matrix : (n, n) in the order of the unknowns, another viscous damping matrix, or 0 for none.
    structural_matrix : (n, n), what `structural` is of in place of K.
    """

    stiffness: float = 0.0
    mass: float = 0.0
    structural: float = 0.0
    matrix: np.ndarray | float = 0.0
    structural_matrix: np.ndarray | None = None

    def viscous(self, K, M):
        """C [N s/m]."""
        return self.stiffness * K + self.mass * M + self.matrix

    def hysteretic(self, K):
        """What i is times of in all harmonics but the mean [N/m]."""
        return self.structural * (K if self.structural_matrix is None else self.structural_matrix)


class HarmonicBalance:
    """The equations (11) in real form. Unknowns q : (N_a + 3 N_x, 2H+1), modal ones first, measured from preload.

    damping : a `Damping`, or a number, its stiffness [s]; fourier : coefficients [a0, a1, b1, ...] of f(t), or, with several load
    patterns, one such series for each; N : samples per period.
    """

    def __init__(self, reduced, contact, preload, damping, fourier, H, N):
        patterns = np.atleast_2d(np.concatenate([reduced.fa, reduced.fx], axis=-1))
        courses = [fourier] if np.ndim(fourier[0]) == 0 else fourier
        if len(courses) != len(patterns):
            raise ValueError(f"{len(courses)} courses for {len(patterns)} load patterns; one for each is wanted")
        longest = max(map(len, courses))
        if longest > 2 * H + 1:
            raise ValueError(f"the excitation has {longest} coefficients, {H} harmonics carry {2 * H + 1}")
        self.contact, self.preload, self.H, self.N = contact, preload, H, N
        self.index = np.zeros(H + 1, int)  # harmonics of one number have the same matrices
        self.damping = damping if isinstance(damping, Damping) else Damping(damping)
        self.modes = len(reduced.kaa)
        self.K = scipy.linalg.block_diag(np.diag(reduced.kaa), reduced.kxx)
        self.M = np.block([[np.eye(self.modes), reduced.max], [reduced.max.T, reduced.mxx]])
        self.C = self.damping.viscous(self.K, self.M)
        self.shape = (len(self.K), 2 * H + 1)
        self.excitation = np.zeros(self.shape)
        for pattern, course in zip(patterns, courses):
            self.excitation[:, :len(course)] += np.outer(pattern, course)

    def matrices(self, k):
        """K and M of harmonic k."""
        return self.K, self.M

    def contact_part(self, q):
        """Coefficients (N_x, 3, 2H+1) of the contact displacements in q."""
        return q[self.modes:].reshape(-1, 3, self.shape[1])

    def harmonic_blocks(self, in_phase, quadrature):
        """Matrix (n (2H+1), n (2H+1)) that has D_k = in_phase(k) + i quadrature(k) as its harmonic k."""
        n, size = self.shape
        matrix = np.zeros((n, size, n, size))
        matrix[:, 0, :, 0] = in_phase(0)
        for k in range(1, self.H + 1):
            c, s = 2 * k - 1, 2 * k
            matrix[:, c, :, c] = matrix[:, s, :, s] = in_phase(k)
            matrix[:, c, :, s] = quadrature(k)
            matrix[:, s, :, c] = -quadrature(k)
        return matrix.reshape(n * size, n * size)

    def _blocks(self, of):
        complex_ones = [of(k) for k in range(self.H + 1)]
        return self.harmonic_blocks(lambda k: complex_ones[k].real, lambda k: complex_ones[k].imag)

    def _at(self, k, omega):
        """D_k = K - k^2 omega^2 M + i (k omega C + S) for harmonics k > 0; K for the mean."""
        K, M = self.matrices(k)
        return K - (k * omega) ** 2 * M + self.damper(k, omega)

    def damper(self, k, omega):
        """i (k omega C + S), what damping adds to harmonic k."""
        K, M = self.matrices(k)
        return 1j * (k * omega * self.damping.viscous(K, M) + (k > 0) * self.damping.hysteretic(K))

    def dynamic_stiffness(self, omega):
        """Matrix (n (2H+1), n (2H+1)) of all D_k."""
        return self._blocks(lambda k: self._at(k, omega))

    def times(self, of, q):
        """Coefficients, in the shape of q, of the forces with the complex matrices of(k) on the motion q, harmonic by harmonic."""
        out = np.zeros(self.shape)
        out[:, 0] = of(0).real @ q[:, 0]
        for k in range(1, self.H + 1):
            c, s = 2 * k - 1, 2 * k
            force = of(k) @ (q[:, c] - 1j * q[:, s])
            out[:, c], out[:, s] = force.real, -force.imag
        return out

    def structure(self, q, omega):
        """Coefficients of the forces of the structure, inertia and damping included, without contacts and loads, in the shape of q."""
        return self.times(lambda k: self._at(k, omega), q)

    def residual(self, q, omega):
        """Left-hand side of (11) [N], in the shape of q."""
        r = self.structure(q, omega) - self.excitation
        G = contact_coefficients(self.contact_part(q), self.contact, self.preload, self.N)
        r[self.modes:] += G.reshape(-1, self.shape[1])
        return r

    def jacobian(self, q, omega):
        """Derivative of the flattened residual with respect to the flattened q (12)."""
        n, size = self.shape
        matrix = self.dynamic_stiffness(omega).reshape(n, size, n, size)
        blocks = contact_jacobian(self.contact_part(q), self.contact, self.preload, self.N)
        for point, block in enumerate(blocks):
            rows = slice(self.modes + 3 * point, self.modes + 3 * point + 3)
            matrix[rows, :, rows, :] += block
        return matrix.reshape(n * size, n * size)

    def omega_derivative(self, q, omega):
        """Derivative of the residual with respect to omega (13), in the shape of q."""
        def of(k):
            K, M = self.matrices(k)
            return -2 * k ** 2 * omega * M + 1j * k * self.damping.viscous(K, M)

        return (self._blocks(of) @ q.ravel()).reshape(self.shape)

    def solve(self, omega, q0=None):
        """Newton's method at one frequency [rad/s], from q0 (default: rest in the preload state)."""
        start = np.zeros(self.shape) if q0 is None else q0
        return newton(lambda z: self.residual(z.reshape(self.shape), omega).ravel(),
                      lambda z: self.jacobian(z.reshape(self.shape), omega), start.ravel()).reshape(self.shape)

    def continuation(self, omega_from, omega_to, step, largest=np.inf, smallest=1e-7, points=2000, q0=None):
        """Follow the solution by pseudo arc length: predictor along the tangent, corrector perpendicular to it.

        step, largest, smallest : arc lengths in the norm of [q, omega], user units. The step is halved when Newton's
        method fails and grows by a quarter when it does not. Ends exactly at omega_to.

        Returns omega (n,) [rad/s] and q (n, N_a + 3 N_x, 2H+1).
        """
        omega, q = zip(*islice(self.branch(omega_from, omega_to, step, largest, smallest, q0), points))
        return np.array(omega), np.array(q)

    def branch(self, omega_from, omega_to, step, largest=np.inf, smallest=1e-7, q0=None):
        """The points (omega, q) of `continuation` one by one, so that those before a failure are not lost."""
        def correct(predicted, tangent):
            return newton(lambda y: np.append(self.residual(y[:-1].reshape(self.shape), y[-1]), tangent @ (y - predicted)),
                          lambda y: self.bordered(y, tangent), predicted, iterations=10)

        sense = np.sign(omega_to - omega_from)
        y = np.append(self.solve(omega_from, q0), omega_from)
        yield omega_from, y[:-1].reshape(self.shape)
        tangent = sense * np.eye(len(y))[-1]
        while y[-1] != omega_to:
            tangent = self.tangent(y, tangent)
            try:
                new = correct(y + step * tangent, tangent)
            except RuntimeError:
                step /= 2
                if step < smallest:
                    raise
                continue
            if sense * (new[-1] - omega_to) >= 0:
                part = (omega_to - y[-1]) / (new[-1] - y[-1])
                start = (y + part * (new - y))[:-1].reshape(self.shape)
                new = np.append(self.solve(omega_to, start), omega_to)
            y = new
            yield y[-1], y[:-1].reshape(self.shape)
            step = min(1.25 * step, largest)

    def bordered(self, y, row):
        """Jacobian with respect to y = [q, omega], completed by `row`."""
        q = y[:-1].reshape(self.shape)
        column = self.omega_derivative(q, y[-1]).ravel()
        return np.vstack([np.column_stack([self.jacobian(q, y[-1]), column]), row])

    def tangent(self, y, before):
        """Unit tangent of the solution curve at y = [q, omega], in the sense of the tangent `before`."""
        tangent = np.linalg.solve(self.bordered(y, before), np.eye(len(y))[-1])
        return tangent / np.linalg.norm(tangent)
