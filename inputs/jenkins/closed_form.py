"""The closed form beside a run of the Jenkins element: a table of the peak and of the whole curve, and a picture.

    $PYTHON inputs/jenkins/closed_form.py out/results.h5            # writes out/jenkins.png

Under x = X cos(omega t), X beyond X_s = mu N / k_t, the first harmonic of the slider is a spring k_s and a loss 4 mu N (X - X_s)
per period. With cos(theta) = 1 - 2 X_s / X:

    k_s = k_t (theta - sin(theta) cos(theta)) / pi          b = 4 mu N (1 - X_s / X) / pi, the force against the velocity
    (k + k_s - m omega^2)^2 X^2 + b^2 = F^2                 so two frequencies for each X, one at the peak, where b = F
"""

import argparse
from pathlib import Path

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

from dovetail import Results  # noqa: E402

MASS, K = 1.0, 1e6  # of model.py [kg], [N/m]
TANGENTIAL, LIMIT, FORCE = 5e5, 10.0, 10.0  # k_t [N/m], mu N [N], F [N] of case.toml
SLIP = LIMIT / TANGENTIAL  # X_s [m]
PEAK = SLIP / (1 - np.pi * FORCE / (4 * LIMIT))  # [m], where b = F; without end beyond F = 4 mu N / pi


def curve(X):
    """Both frequencies (n, 2) [rad/s] at which the mass moves by X (n,) [m]: below and above the peak."""
    theta = np.arccos(1 - 2 * np.minimum(SLIP / X, 1))
    spring = TANGENTIAL / np.pi * (theta - np.sin(theta) * np.cos(theta))
    loss = 4 * LIMIT / np.pi * np.maximum(1 - SLIP / X, 0)
    apart = np.sqrt(np.maximum(FORCE**2 - loss**2, 0)) / X
    return np.sqrt((K + spring[:, None] + apart[:, None] * [-1, 1]) / MASS)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("results", type=Path)
    path = parser.parse_args().results

    results = Results(path)
    response = results.response("x1.t1")
    [(omega, peak)] = response.peaks()
    frequency = curve(np.array([PEAK]))[0, 0]
    off = np.abs(curve(response.amplitude) / results.omega[:, None] - 1).min(axis=1).max()
    print(f"peak [m]           {peak:.6e}   closed form {PEAK:.6e}")
    print(f"at [rad/s]         {omega:.3f}       closed form {frequency:.3f}")
    print(f"all {len(results)} points lie within {off:.0e} of the closed form, as a share of the frequency")

    X = np.linspace(response.amplitude.min(), PEAK, 1000)
    figure, axis = plt.subplots(figsize=(6, 3.6), layout="constrained")
    for i, side in enumerate(curve(X).T):
        axis.plot(side, 1e6 * X, color="#c1440e", label=None if i else "closed form")
    axis.plot(results.omega, 1e6 * response.amplitude, "o", color="black", markersize=3.5, label="points of the run")
    axis.axhline(1e6 * SLIP, color="#7f7f7f", linestyle="--", label="slips above")
    axis.set(xlabel="excitation frequency [rad/s]", ylabel="amplitude x1.t1 [µm]", xlim=np.sort(results.omega[[0, -1]]), ylim=(0, None))
    axis.legend(frameon=False)
    picture = path.with_name("jenkins.png")
    figure.savefig(picture, dpi=110)
    print(picture)


if __name__ == "__main__":
    main()
