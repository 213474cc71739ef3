"""Campbell diagram of a sector: frequencies of the nodal diameters that the load meets, and its engine orders, over the rotor speed."""

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

from .diameters_picture import of_wheel  # noqa: E402
from .plot import LINES, STYLE  # noqa: E402
from .plot_labels import place_labels  # noqa: E402
from .units import bracket  # noqa: E402

ROOM = 1.2  # of the fastest rotor of the run, and of what its engine orders reach there: width and height of the picture
PER_MINUTE = 60.0


def campbell(results, hz=False):
    """Frequency over the rotor speed Om / |EO|: level lines of each nodal diameter, rising ones of the engine orders that meet it.

    The stuck structure does not change with the speed, so its lines are level. Dots are where a harmonic of the load meets a frequency of
    its nodal diameter, full ones within the sweep. `hz`: frequencies in Hz, rotor speed in turns per minute.
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
        swept = axis.axvspan(turning * slow, turning * fast, color=LINES[2][0], alpha=0.15, linewidth=0, label="sweep of the run")
        handles, met = [], []
        for i, diameter in enumerate(dict.fromkeys(np.abs(wave.index[1:]).tolist())):
            style = {"color": LINES[i % len(LINES)][0], "linestyle": LINES[i % len(LINES)][1]}
            frequencies = wave.frequencies[diameter]
            axis.hlines(scale * frequencies[frequencies < top], 0, turning * widest, linewidth=0.9, **style)
            orders = [order * k for k in range(1, last + 1) if abs(wave.index[k]) == diameter]
            for engine_order in orders:
                axis.plot([0, turning * widest], [0, scale * engine_order * widest], linewidth=1.6, **style)
                speeds = frequencies / engine_order
                met += [(speed, f, engine_order, diameter, style["color"]) for speed, f in zip(speeds, frequencies) if speed < widest]
            said = ", ".join(map(str, orders))
            handles += axis.plot([], [], **style, label=f"nodal diameter {diameter}, engine order{'s' * (len(orders) > 1)} {said}")
        for speed, f, _, _, colour in met:
            inside = slow <= speed <= fast
            axis.plot(turning * speed, scale * f, "o", color=colour, markersize=6, markerfacecolor=colour if inside else "white", zorder=3)
        handles += [swept, *axis.plot([], [], "o", color="black", linestyle="none", label="crossed in the sweep"),
                    *axis.plot([], [], "o", color="black", markerfacecolor="white", linestyle="none", label="crossed elsewhere")]
        axis.set(xlabel="rotor speed" + bracket(turning_unit), ylabel="frequency" + bracket(unit), xlim=(0, turning * widest),
                 ylim=(0, scale * top), title=f"{results.title or results.path.name}: {wave.sectors} sectors, engine order "
                 f"{wave.engine_order}")
        axis.legend(handles=handles, loc="upper center", bbox_to_anchor=(0.5, -0.13), ncol=2, handlelength=3.2)
        inside = sorted(met, key=lambda place: not slow <= place[0] <= fast)
        place_labels(axis, [[(turning * speed, scale * f, f"EO {engine_order}: {scale * f:.5g}") for speed, f, engine_order, *_ in inside]],
                     [(turning * speed, scale * f) for speed, f, *_ in met], "white")
    return figure
