"""Tables for pandas, which is not needed otherwise."""

from .friction_energy import per_period

STATES = ("stick", "slip", "open")


def frame(columns):
    """A pandas.DataFrame of columns by name."""
    try:
        import pandas
    except ImportError:
        raise ImportError("to_frame needs pandas, which is not installed: apt-get install python3-pandas, or pip install pandas; "
                          "columns() gives the same table without it") from None
    return pandas.DataFrame(columns)


def columns_of(results, dofs):
    """As `Results.columns`."""
    table = {"omega": results.omega, "frequency": results.frequency}
    if results.parameter is not None:
        table[results.parameter_name] = results.parameter
    dofs = results.watched if dofs is None else dofs
    names = [dofs] if isinstance(dofs, (str, int)) else list(dofs)
    table |= {curve.name: curve.amplitude for curve in results.response(names)}
    table |= {state: results.points(state) for state in STATES}
    if results.has_activity:
        table["friction_energy"] = per_period(results)
    further = {"damping_ratio": results.damping_ratio, "force_level": results.force_level, "stable": results.stable,
               "multiplier": results.multiplier, "error": results.error}
    return table | {name: values for name, values in further.items() if values is not None}
