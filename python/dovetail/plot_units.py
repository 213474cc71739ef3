"""Units in pictures: those of the SI with a prefix on the ticks, others in the label of the axis, unknown ones nowhere."""

from matplotlib.ticker import EngFormatter

from .units import bracket, with_unit

BASE_UNITS = ("m", "s", "J", "N", "Pa", "J/m²")  # with a prefix, as in 20 µm


def formatter(unit):
    """For ticks and colour bars; None where numbers are plain."""
    return EngFormatter(unit) if unit in BASE_UNITS else None


def labelled(label, unit):
    """The label of an axis with such ticks."""
    return label if unit in BASE_UNITS else label + bracket(unit)


def dress(axis, label, unit):
    """Ticks and label of an axis (`figure.axes[0].xaxis`)."""
    if unit in BASE_UNITS:
        axis.set_major_formatter(EngFormatter(unit))
    axis.set_label_text(labelled(label, unit))


def round_text(number, unit):
    """A number of one digit with its unit."""
    return EngFormatter(unit)(number) if unit in BASE_UNITS else with_unit(f"{number:g}", unit)


def value_text(number, unit):
    """A number with its unit, in four digits or so."""
    return EngFormatter(unit, places=3)(number) if unit in BASE_UNITS else with_unit(f"{number:.4g}", unit)
