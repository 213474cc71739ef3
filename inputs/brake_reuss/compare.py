"""The backbone of a run beside the one that others computed, peer.csv: a table over the amplitude at the tip, and a picture.

    $PYTHON inputs/brake_reuss/compare.py out/results.h5            # writes out/brake_reuss.png
"""

import argparse
from pathlib import Path

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

from dovetail import Results  # noqa: E402

AMPLITUDES = (1e-7, 4e-7, 1e-6, 4e-6, 1e-5, 2e-5, 4e-5, 6e-5)  # at the tip [m]


def peer():
    """Amplitude [m], frequency [Hz], damping ratio, each (n,), of the others."""
    return np.loadtxt(Path(__file__).with_name("peer.csv"), delimiter=",").T


def run(path):
    """The same of a run. Raises ValueError where its results have no nonlinear mode."""
    results = Results(path)
    if results.damping_ratio is None:
        raise ValueError(f"{path}: no nonlinear mode was followed")
    return results.amplitude("tip.z"), results.omega / (2 * np.pi), results.damping_ratio


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("results", type=Path)
    path = parser.parse_args().results

    curves = {"others": peer(), "Dovetail": run(path)}
    print("| tip [m] | f / f0, others | f / f0 | damping ratio, others | damping ratio |\n|---|---|---|---|---|")
    for amplitude in AMPLITUDES:
        shift, damping = zip(*[(np.interp(amplitude, a, f / f[0]), np.interp(amplitude, a, zeta)) for a, f, zeta in curves.values()])
        print(f"| {amplitude:.0e} |", " | ".join([*(f"{value:.4f}" for value in shift), *(f"{value:.2e}" for value in damping)]), "|")

    figure, axes = plt.subplots(1, 2, figsize=(9, 3.6), layout="constrained")
    for (name, (amplitude, frequency, zeta)), look in zip(curves.items(), ({"marker": "o", "markersize": 3.5, "color": "#c1440e"},
                                                                           {"color": "black"})):
        axes[0].semilogx(amplitude, frequency / frequency[0], label=f"{name}, f0 = {frequency[0]:.1f} Hz", **look)
        axes[1].loglog(amplitude, zeta, label=name, **look)
    axes[0].set(xlabel="amplitude at the tip [m]", ylabel="frequency / f0", xlim=(1e-7, 1e-4))
    axes[1].set(xlabel="amplitude at the tip [m]", ylabel="damping ratio", xlim=(1e-7, 1e-4))
    for axis in axes:
        axis.grid(color="#e0e0e0")
        axis.legend(frameon=False)
    picture = path.with_name("brake_reuss.png")
    figure.savefig(picture, dpi=110)
    print(picture)


if __name__ == "__main__":
    main()
