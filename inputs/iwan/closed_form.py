"""The closed form beside runs of the Iwan element, over the frequency and over the amplitude: a table and a picture.

    $PYTHON inputs/iwan/closed_form.py out/results.h5 out/mode/results.h5     # writes out/iwan.png

Without end of sliders, whose limits go evenly from 0 to 2 mu N, all slip from S = 2 mu N / k_t on.
Under x = X cos(omega t), X up to S, the force on the way back is exactly

    T = k_t ((1 - X / 2 S) x - (X^2 - x^2) / 4 S)           whose first harmonic is a spring and a loss:
    k_s = k_t (1 - X / 2 S)         b = 2 k_t X^2 / (3 pi S), the force against the velocity
    (k + k_s - m omega^2)^2 X^2 + b^2 = F^2                 so two frequencies for each X, one at the peak, where b = F
"""

import argparse
from pathlib import Path

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

from dovetail import Results  # noqa: E402

MASS, K, TANGENTIAL = 1.0, 1e6, 5e5  # of model.py [kg], [N/m], k_t [N/m]
LIMIT, FORCE = 20.0, 5.0  # mu N of all sliders, F of case.toml [N]
SLIP = 2 * LIMIT / TANGENTIAL  # S [m], where the last one slips
PEAK = np.sqrt(3 * np.pi * SLIP * FORCE / (2 * TANGENTIAL))  # [m], where b = F; below S


def spring(X):
    """k_s [N/m] at amplitudes X up to S [m]."""
    return TANGENTIAL * (1 - X / (2 * SLIP))


def loss(X):
    """b [N]."""
    return 2 * TANGENTIAL * X**2 / (3 * np.pi * SLIP)


def curve(X):
    """Both frequencies (n, 2) [rad/s] at which the mass moves by X (n,) [m]: below and above the peak."""
    apart = np.sqrt(np.maximum(FORCE**2 - loss(X) ** 2, 0)) / X
    return np.sqrt((K + spring(X)[:, None] + apart[:, None] * [-1, 1]) / MASS)


def backbone(X):
    """Frequency [rad/s] of the resonance of amplitude X [m], and its damping ratio."""
    omega = np.sqrt((K + spring(X)) / MASS)
    return omega, loss(X) / (2 * MASS * omega**2 * X)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("results", type=Path, help="of case.toml")
    parser.add_argument("mode", type=Path, help="of mode.toml")
    path, mode = vars(parser.parse_args()).values()

    results, mode = Results(path), Results(mode)
    response = results.response("x1.t1")
    [(omega, peak)] = response.peaks()
    print(f"peak [m]           {peak:.6e}   closed form {PEAK:.6e}")
    print(f"at [rad/s]         {omega:.3f}       closed form {backbone(PEAK)[0]:.3f}")
    X = mode.modal_amplitude / np.sqrt(MASS)
    omega, ratio = backbone(X)
    print(f"over the amplitude the frequency is off by {np.abs(mode.omega / omega - 1).max():.0e} at most,")
    print(f"the damping ratio by {np.abs(mode.damping_ratio - ratio).max():.0e}")

    figure, axes = plt.subplots(1, 2, figsize=(9, 3.6), layout="constrained")
    closed = np.linspace(response.amplitude.min(), PEAK, 1000)
    for side in curve(closed).T:
        axes[0].plot(side, 1e6 * closed, color="#c1440e")
    axes[0].plot(results.omega, 1e6 * response.amplitude, "o", color="black", markersize=3.5)
    axes[0].set(xlabel="excitation frequency [rad/s]", ylabel="amplitude x1.t1 [µm]", xlim=np.sort(results.omega[[0, -1]]), ylim=(0, None))
    closed = np.linspace(1e-3, 1, 100) * SLIP
    axes[1].plot(1e6 * closed, backbone(closed)[1], color="#c1440e", label="closed form")
    axes[1].plot(1e6 * X, mode.damping_ratio, "o", color="black", markersize=3.5, label="points of the run")
    axes[1].set(xlabel="amplitude x1.t1 [µm]", ylabel="damping ratio", xlim=(0, None), ylim=(0, None))
    axes[1].legend(frameon=False)
    picture = path.with_name("iwan.png")
    figure.savefig(picture, dpi=110)
    print(picture)


if __name__ == "__main__":
    main()
