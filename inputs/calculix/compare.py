"""The first harmonic of the end beside CalculiX's own contact dynamics: a table and a picture.

    $PYTHON inputs/calculix/compare.py          # after model.py 6250 6550 7000; runs case.toml, writes out/calculix.png
"""

import re
from pathlib import Path

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

from dovetail import Results, run  # noqa: E402

HERE = Path(__file__).parent
HERTZ = 6250, 6550, 7000
STEPS, TIP = 64, 78  # of a period of model.py, node of the deck


def calculix(hertz):
    """Amplitude [mm] of the first harmonic in every period, from what *NODE PRINT wrote."""
    text = (HERE / f"out/through{hertz}.dat").read_text()
    y = np.array(re.findall(rf"^ +{TIP} +\S+ +(\S+) +\S+$", text, re.MULTILINE), dtype=float)
    turns = np.exp(2j * np.pi * np.arange(1, STEPS + 1) / STEPS)
    return np.abs(y.reshape(-1, STEPS) @ turns) * 2 / STEPS


def dovetail(model):
    """Results with points at these frequencies, and the amplitude [mm] of the first harmonic at every point."""
    results = run(HERE / "case.toml", out=HERE / "out" / Path(model).stem, model=str(HERE / model),
                  **{"continuation.at": [2 * np.pi * hertz for hertz in HERTZ]})
    coefficients = results.response("TIP.y").coefficients  # a0, a1, b1, ...
    return results, np.hypot(coefficients[:, 1], coefficients[:, 2])


def main():
    (results, plain), (_, simpson) = dovetail("out/model.h5"), dovetail("out/simpson.h5")
    others = Results(HERE / "out/simpson/results.h5")
    print("f [Hz]   CalculiX [um]   last period by   Dovetail [um]           Simpson's shares [um]")
    for hertz in HERTZ:
        course = calculix(hertz)
        one, two = plain[results.at(2 * np.pi * hertz)], simpson[others.at(2 * np.pi * hertz)]
        last = course[-1]
        print(f"| {hertz} Hz | {1e3 * last:.3f} um | {100 * (last / course[-2] - 1):.2f} % | {1e3 * one:.3f} um | "
              f"{100 * (one / last - 1):.2f} % | {1e3 * two:.3f} um | {100 * (two / last - 1):.2f} % |")

    figure, axis = plt.subplots(figsize=(6, 3.6), layout="constrained")
    axis.plot(results.frequency, 1e3 * plain, color="#7f7f7f", linestyle="--", label="Dovetail, areas of the nodes")
    axis.plot(others.frequency, 1e3 * simpson, color="#c1440e", label="Dovetail, Simpson's shares")
    axis.plot(HERTZ, [1e3 * calculix(hertz)[-1] for hertz in HERTZ], "o", color="black", label="CalculiX, through time")
    axis.set(xlabel="excitation frequency [Hz]", ylabel="first harmonic of TIP.y [µm]", ylim=(0, None))
    axis.legend(frameon=False, loc="lower center")
    picture = HERE / "out/calculix.png"
    figure.savefig(picture, dpi=110)
    print(picture.name)


if __name__ == "__main__":
    main()
