"""Picture of a sector's frequencies over the nodal diameter, with the zig-zag line of engine orders (SAFE or ZZENF diagram)."""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.ticker import MaxNLocator

from .plot import LINES, STYLE
from .plot_labels import place_labels, no_formula
from .units import bracket

ROOM = 1.25  # of what the engine orders reach: the height of the picture


def folded(order, sectors):
    """Nodal diameter on which an engine order falls, from 0 to N/2; between whole ones along the line."""
    rest = np.asarray(order, dtype=float) % sectors
    return np.minimum(rest, sectors - rest)


def zigzag(sectors, highest):
    """(nodal diameters, engine orders) of the corners of the line, from engine order 0 to the highest."""
    orders = np.append(np.arange(0.0, highest, sectors / 2), highest)
    return folded(orders, sectors), orders


def crossings(wave, lowest, highest):
    """(harmonic, nodal diameter, frequency) of each frequency that a harmonic of the load meets in a sweep from lowest to highest."""
    return [(k, int(h), float(f)) for k, h in enumerate(np.abs(wave.index)) if k
            for f in wave.frequencies[h] if k * lowest <= f <= k * highest]


def of_wheel(results):
    """The TravellingWave with its frequencies; ValueError where there is none."""
    wave = results.wave
    if wave is None:
        raise ValueError(f"{results.path}: is not of a sector of a cyclic structure, so it has no nodal diameters")
    if wave.frequencies is None or not wave.frequencies.size:
        raise ValueError(f"{results.path}: has no /cyclic/frequencies: it was written by an older version; run the case again")
    return wave


def diameters(results, hz=False):
    """Frequency over the nodal diameter, and where the sweep of the run crosses it.

    Lines are the engine orders at the lowest and the highest rotor speed of the run, Om / |EO|, bars what each harmonic sweeps
    over, dots the crossings. `hz`: frequencies in Hz.
    """
    wave = of_wheel(results)
    scale, unit = (results.unit.hertz(1.0), "Hz") if hz else (1.0, results.unit.omega)
    lowest, highest = float(results.omega.min()), float(results.omega.max())
    order, last = abs(wave.engine_order), len(wave.index) - 1
    met = crossings(wave, lowest, highest)
    top = min(1.04 * wave.frequencies.max(), ROOM * max(last * highest, wave.frequencies[:, 0].max()))
    bar = {"color": LINES[1][0], "linewidth": 3.5, "solid_capstyle": "butt", "alpha": 0.6}
    with plt.rc_context(STYLE):
        figure, axis = plt.subplots(figsize=(7.5, 5.2), layout="constrained")
        style = {"color": "#b5b5b5", "linewidth": 0.8, "marker": "o", "markersize": 3, "markerfacecolor": "white",
                 "markeredgecolor": "#7f7f7f"}
        axis.plot(scale * wave.frequencies, **style)
        handles = axis.plot([], [], **style, label="closed points stuck")
        if order and last:
            handles += _engine_orders(axis, wave.sectors, order * last, scale * lowest / order, scale * highest / order, unit)
        bars = [(abs(int(wave.index[k])), k) for k in range(1, last + 1)]
        for h, k in bars:
            axis.plot([h, h], [scale * k * lowest, scale * k * highest], **bar)
        passed = "sweep" if results.parameter is None else "range"  # that of a mode is what friction does
        handles += axis.plot([], [], **bar, label=f"{passed} of a harmonic")
        if met:
            handles += axis.plot([h for _, h, _ in met], [scale * f for *_, f in met], "o", color=LINES[1][0], markersize=6,
                                 label=f"crossed in the {passed}")
        axis.set(xlabel="nodal diameter", ylabel="frequency" + bracket(unit), ylim=(0, scale * top),
                 title=f"{no_formula(results.title or results.path.name)}: {wave.sectors} sectors, engine order {wave.engine_order}")
        axis.xaxis.set_major_locator(MaxNLocator(integer=True))
        axis.margins(x=0.06)
        axis.legend(handles=handles, loc="upper center", bbox_to_anchor=(0.5, -0.13), ncol=2, handlelength=3.2)
        place_labels(axis, [[(h, scale * f, f"EO {order * k}: {scale * f:.5g}") for k, h, f in met],
                            [(h, scale * k * highest, f"EO {order * k}") for h, k in bars if k not in {k for k, *_ in met}]],
                     [(h, scale * f) for h, row in enumerate(wave.frequencies) for f in row], "white")
    return figure


def _engine_orders(axis, sectors, most, slow, fast, unit):
    """Draws the lines at two rotor speeds, and what lies between them; their entries of the legend."""
    h, orders = zigzag(sectors, most)
    axis.fill(np.append(h, h[::-1]), np.append(slow * orders, fast * orders[::-1]), color=LINES[2][0], alpha=0.12, linewidth=0)
    speeds = {slow: "--", fast: "-"}
    return [axis.plot(h, speed * orders, color=LINES[2][0], linestyle=dashes, linewidth=1.1,
                      label=f"engine orders, rotor at {speed:.4g} {unit}")[0] for speed, dashes in speeds.items()]
