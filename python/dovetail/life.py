"""Mean, amplitude and utilisation of every node of a part, and its worst points."""

from dataclasses import dataclass

import numpy as np

from .fatigue import CRITERIA, Strength, goodman, read_strengths, von_mises
from .nodal_stress import NodalStress, given_material, nodal_stress


@dataclass(frozen=True)
class Life:
    """What the criterion and the strengths make of a NodalStress of P pairs of node and material.

    mean, amplitude : (P,) of the criterion; static : (P,) von Mises stress of the mean tensor
    utilisation : (P,), nan where a material has no strengths; None where no strengths are known
    """

    stress: NodalStress
    criterion: str
    mean: np.ndarray
    amplitude: np.ndarray
    static: np.ndarray
    utilisation: np.ndarray | None = None

    @property
    def ranked(self):
        """(P,) what the worst points have most of: utilisation, else amplitude."""
        return self.amplitude if self.utilisation is None else np.nan_to_num(self.utilisation, nan=-1.0)

    def worst(self, count):
        """The `count` pairs with the largest values of `ranked`, the largest first."""
        return np.argsort(-self.ranked, kind="stable")[:count]

    def of_nodes(self, nodes):
        """For each of some rows of nodes, its worst pair, -1 where it has no stress."""
        order = np.argsort(self.ranked, kind="stable")
        pair = np.full(max(np.max(nodes, initial=0), np.max(self.stress.node, initial=0)) + 1, -1)
        pair[self.stress.node[order]] = order  # the largest comes last
        return pair[nodes]


def life(stress, criterion="sines", strengths=None):
    """The Life of a NodalStress.

    Parameters
    ----------
    stress : NodalStress
    criterion : str
        A key of fatigue.CRITERIA.
    strengths : Strength, or dict of material name to Strength, optional
    """
    mean, amplitude = CRITERIA[criterion](stress.series)
    used = None
    if strengths is not None:
        used = np.full(len(mean), np.nan)
        for number, material in enumerate(stress.materials):
            strength = strengths if isinstance(strengths, Strength) else strengths.get(material.name)
            mine = stress.material == number
            if strength is not None:
                used[mine] = goodman(mean[mine], amplitude[mine], strength)
    return Life(stress, criterion, mean, amplitude, von_mises(stress.series[0] / 2), used)


def asked_life(results, point, arguments, left_out=()):
    """The Life of a point, as the options of `stress` and `export` say (see `add_options`), without some rows of nodes."""
    strengths = asked_strengths(arguments)
    stress = nodal_stress(results, point, material=given_material(arguments.material)).without(left_out)
    if isinstance(strengths, dict):
        names = [stress.materials[number].name for number in np.unique(stress.material)]
        if not any(name in strengths for name in names):
            raise ValueError(f"{arguments.strengths}: has none of the materials of the model, {', '.join(names)}")
    return life(stress, arguments.criterion, strengths)


def asked_strengths(arguments):
    """A Strength, a dict of them, or None."""
    given = arguments.fatigue_strength, arguments.tensile
    if arguments.strengths is not None:
        if given != (None, None):
            raise ValueError("--strengths is a table for each material, --fatigue-strength and --tensile are those of all; give one "
                             "of both")
        return read_strengths(arguments.strengths)
    if None not in given:
        return Strength(*given)
    if given != (None, None):
        raise ValueError("--fatigue-strength and --tensile together make the line of Goodman; give both")
    return None


def add_options(command, finite):
    """Options that `stress` and `export` share; finite: the type of a finite number."""
    command.add_argument("--material", metavar=("E", "NU"), nargs=2, type=finite, help="Young's modulus and Poisson's ratio of cells for "
                         "which the model has no material")
    command.add_argument("--criterion", choices=list(CRITERIA), default="sines", help="what makes an amplitude and a mean of the tensor; "
                         "default: %(default)s")
    command.add_argument("--fatigue-strength", metavar="S", type=finite, help="amplitude that the material endures without a mean "
                         "(R = -1), in units of the model")
    command.add_argument("--tensile", metavar="R", type=finite, help="tensile strength: where the line of Goodman ends")
    command.add_argument("--strengths", metavar="FILE.csv", help="both for each material: material,fatigue_strength,tensile_strength")
