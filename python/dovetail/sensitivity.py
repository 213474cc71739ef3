"""What the peaks of a response depend on: /sensitivity of a results file."""

from dataclasses import dataclass, field

import numpy as np

from .hdf5_read import dataset, members

FACTORS = ("force", "preload", "damping")


@dataclass(frozen=True)
class Sensitivity:
    """Derivatives at m located peaks, in user units.

    omega, amplitude : (m,) rms amplitude sqrt(sum of a_k^2 + b_k^2, k >= 1) of the watched unknown at its maximum, and the frequency
        there [rad/s, or rad per unit of time of the model]
    point : (m,) point of the curve where the peak of its largest displacement lies
    amplitude_by, omega_by : dict
        By `normal_stiffness` (m, N_x), `tangential_stiffness` and `friction` (m, N_x, 2), `gap` (m, N_x), and by factors on `force`,
        `preload` and all `damping` (m,). A cone's one friction is the first of both; NaN where friction is 0.
    values : dict of the parameters' own values, as `Results.contact`
    results : Results that these are of
    """

    omega: np.ndarray
    amplitude: np.ndarray
    point: np.ndarray
    amplitude_by: dict
    omega_by: dict
    values: dict
    results: object = field(default=None, repr=False)

    def __len__(self):
        return len(self.omega)

    def relative(self, name, of="amplitude"):
        """(p / A) dA/dp, or (p / omega) domega/dp: by how many per cent one per cent of a parameter changes the peak. For the gap,
        which may be 0: (1 / A) dA/dgap. Shape as in `amplitude_by`."""
        value, slopes = {"amplitude": (self.amplitude, self.amplitude_by), "omega": (self.omega, self.omega_by)}[of]
        slope = slopes[name]
        factor = 1.0 if name in FACTORS or name == "gap" else self.values[name]
        return factor * slope / value.reshape(-1, *[1] * (slope.ndim - 1))

    def of_points(self, name, of="amplitude"):
        """The same for each contact point, (m, N_x): both directions together, as where a point's parameter is one number."""
        if name in FACTORS:
            raise ValueError(f"{name} is of no contact point; there are {', '.join(self.values_of_points())}")
        values = self.relative(name, of)
        values = np.where(np.isnan(values) & (self.values[name] == 0), 0.0, values)  # a factor on a friction of 0
        return values.sum(axis=2) if values.ndim == 3 else values

    def by_joint(self, name, of="amplitude", model=None):
        """Sums over the points of each joint, a dict of its name to (m,): what a factor common to all its points does, for the gap what
        is added to all. `model`: where the model file is now. Raises ValueError where the joints are not known."""
        from .motion import find_joint

        joint, values = find_joint(self.results, model), self.of_points(name, of)
        return {word: values[:, joint["joint"] == number].sum(axis=1) for number, word in enumerate(joint["names"])}

    def values_of_points(self):
        """The parameters that points have."""
        return [name for name in self.amplitude_by if name not in FACTORS]


def read_sensitivity(file, points, values, results=None):
    """That of an open results file with so many points, or None where none was asked for. Raises ValueError where a table is missing."""
    if "sensitivity" not in file:
        return None
    place = dataset(file, "sensitivity/omega", (None,))
    known = dataset(file, "sensitivity/point", (None,))[:len(place)] < points

    def slopes(of):
        return {name: dataset(file, f"sensitivity/{of}/{name}", (None, ...))[:len(place)][known]
                for name in members(file, f"sensitivity/{of}")}

    return Sensitivity(place[known], dataset(file, "sensitivity/amplitude", (None,))[:len(place)][known],
                       dataset(file, "sensitivity/point", (None,))[:len(place)][known], slopes("amplitude_by"), slopes("omega_by"), values,
                       results)
