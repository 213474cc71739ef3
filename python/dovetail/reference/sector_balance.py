"""Harmonic balance of one sector of a cyclic structure under a load that travels round it."""

import numpy as np
import scipy.linalg

from .balance import HarmonicBalance


class SectorBalance(HarmonicBalance):
    """Equations in which harmonic k has the Hermitian K and M, and the complex F, of its index h_k; those of -h are conjugate.

    models : for h = 0 .. N/2 `Reduced`, complex but for the first
    index : (H+1,) h of every harmonic, 0 of the mean
    Other parameters as of HarmonicBalance; `K`, `M` and `C` are those of the mean.
    """

    def __init__(self, models, index, contact, preload, damping, fourier, H, N):
        super().__init__(models[0], contact, preload, damping, fourier, H, N)
        self.index = np.asarray(index)
        courses = [fourier] if np.ndim(fourier[0]) == 0 else fourier
        self._matrices, patterns = [], []
        for one in models:
            K = scipy.linalg.block_diag(np.diag(one.kaa), one.kxx)
            self._matrices.append((K, np.block([[np.eye(self.modes), one.max], [one.max.conj().T, one.mxx]])))
            patterns.append(np.atleast_2d(np.concatenate([one.fa, one.fx], axis=-1)))
        self.excitation[:, 1:] = 0
        for j, course in enumerate(courses):
            series = np.zeros(self.shape[1])
            series[:len(course)] = course
            for k in range(1, H + 1):
                force = self._of(k, [pattern[j] for pattern in patterns]) * (series[2 * k - 1] - 1j * series[2 * k])
                self.excitation[:, 2 * k - 1] += force.real
                self.excitation[:, 2 * k] -= force.imag

    def _of(self, k, by_index):
        h = self.index[k]
        return by_index[h] if h >= 0 else by_index[-h].conj()

    def matrices(self, k):
        return self.of_index(self.index[k])

    def of_index(self, h):
        """K and M of an index of any sign."""
        return tuple(matrix if h >= 0 else matrix.conj() for matrix in self._matrices[abs(h)])
