"""Campbell diagram of a sector: frequencies of the nodal diameters that the load meets, and its engine orders, over the rotor speed."""

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

from .diameters_picture import crossings, of_wheel  # noqa: E402
from .plot import LINES, STYLE  # noqa: E402
from .plot_labels import place_labels, no_formula  # noqa: E402
from .units import bracket  # noqa: E402

ROOM = 1.2  # of the fastest rotor of the run, and of what its engine orders reach there: width and height of the picture
PER_MINUTE = 60.0


def campbell(results, hz=False):
    """Frequency over the rotor speed Om / |EO|: level lines of each nodal diameter, rising ones of the engine orders that meet it.

    The stuck structure does not change with the speed, so its lines are level. Dots are where a harmonic of the load meets a frequency of
    its nodal diameter, full ones within the sweep over the frequency, if the run is one. `hz`: frequencies in Hz, rotor speed in turns
    per minute.
    """
    wave = of_wheel(results)
    order, last = abs(wave.engine_order), len(wave.index) - 1
    if order == 0 or last == 0:
        raise ValueError(f"{results.path}: under engine order 0 the load does not travel, so there is no rotor speed to draw over" if last
                         else f"{results.path}: has no harmonics, so no engine order rises with the rotor speed")
    scale, unit = (results.unit.hertz(1.0), "Hz") if hz else (1.0, results.unit.omega)
    turning, turning_unit = (PER_MINUTE * scale, "1/min") if hz else (1.0, unit)
    slow, fast = results.omega.min() / order, results.omega.max() / order
    widest, top = ROOM * fast, ROOM * last * order * fast
    with plt.rc_context(STYLE):
        figure, axis = plt.subplots(figsize=(7.5, 5.2), layout="constrained")
        sweeps = results.parameter is None
        handles, styles, lines = [], {}, []
        for i, diameter in enumerate(dict.fromkeys(np.abs(wave.index[1:]).tolist())):
            style = styles[diameter] = {"color": LINES[i % len(LINES)][0], "linestyle": LINES[i % len(LINES)][1]}
            level = scale * wave.frequencies[diameter][wave.frequencies[diameter] < top]
            axis.hlines(level, 0, turning * widest, linewidth=0.9, **style)
            lines += [((0, f), (turning * widest, f)) for f in level]
            orders = [order * k for k in range(1, last + 1) if abs(wave.index[k]) == diameter]
            for engine_order in orders:
                axis.plot([0, turning * widest], [0, scale * engine_order * widest], linewidth=1.6, **style)
                lines.append(((0, 0), (turning * widest, scale * engine_order * widest)))
            said = ", ".join(map(str, orders))
            handles += axis.plot([], [], **style, label=f"nodal diameter {diameter}, engine order{'s' * (len(orders) > 1)} {said}")
        swept = crossings(wave, order * slow, order * fast) if sweeps else []
        met = swept + [place for place in crossings(wave, 0.0, order * widest) if place not in swept]
        places = [(turning * f / (order * k), scale * f, f"EO {order * k}: {scale * f:.5g}") for k, _, f in met]
        for i, ((_, diameter, _), (x, y, _)) in enumerate(zip(met, places)):
            colour = styles[diameter]["color"]
            axis.plot(x, y, "o", color=colour, markersize=6, markerfacecolor=colour if i < len(swept) else "white", zorder=3)
        dot = {"color": "black", "marker": "o", "linestyle": "none"}
        handles += axis.plot([], [], color="black", linewidth=0.9, label="level: closed points stuck")
        if sweeps:
            handles += [axis.axvspan(turning * slow, turning * fast, color=LINES[2][0], alpha=0.15, linewidth=0, label="sweep of the run"),
                        *axis.plot([], [], **dot, label="crossed in the sweep")]
        handles += axis.plot([], [], **dot, markerfacecolor="white", label="crossed elsewhere" if sweeps else "crossed")
        axis.set(xlabel="rotor speed" + bracket(turning_unit), ylabel="frequency" + bracket(unit), xlim=(0, turning * widest),
                 ylim=(0, scale * top), title=f"{no_formula(results.title or results.path.name)}: {wave.sectors} sectors, engine order "
                 f"{wave.engine_order}")
        axis.legend(handles=handles, loc="upper center", bbox_to_anchor=(0.5, -0.13), ncol=2, handlelength=3.2)
        place_labels(axis, [places], [(x, y) for x, y, _ in places], "white", lines)
    return figure
