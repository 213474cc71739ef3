"""The sector of whole_rotor.py under a small load: a resonance at which few contact points slip."""

import re

import numpy as np

import cases
import cyclic_sector

# Friction: all points stick at rest, and two of them slip in one direction, alike in both senses.
SHROUD = np.repeat([[0.8, 0.8], [0.03, 0.8]], [6, 2], axis=0)
OMEGA = {1: (2320.0, 2360.0), 2: (1970.0, 2020.0)}  # around the first mode of nodal diameter 1 and 2


def scene(folder, order, force=9.0, harmonics=5, modes=12, more="", omega=None, name="eo2_separation", edit=str, **contact):
    """A case over the frequency. `harmonics` None leaves them to a tolerance in `more`, `omega` "" the sweep to another kind of run;
    `contact`: parameters in place of those given."""
    path, _ = cyclic_sector.write(folder, name, 2000.0, samples='"exact"', modes=modes)
    omega = OMEGA[order] if omega is None else omega
    lines = {"continuation.omega": f"continuation.omega = {list(omega)}\ncontinuation.adaptive = true" if omega else "",
             "harmonic_balance": f"harmonic_balance.harmonics = {harmonics}" if harmonics else "",
             "excitation.engine_order": f"excitation.engine_order = {order}",
             "newton": "newton = { step_tolerance = 1e-8, residual_tolerance = 1e-8 }\n" + more,
             "fourier": f"fourier = [0.0, {force!r}]"}
    lines |= {f"contact.{key}": f"contact.{key} = {values.tolist()}" for key, values in contact.items()}
    text = path.read_text()
    for key, line in lines.items():
        text, found = re.subn(rf"(?m)^{re.escape(key)} = .*$", line, text)
        assert found == 1, key
    path.write_text(edit(text))
    return cases.Case(path, None, None, {})
