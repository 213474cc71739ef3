"""Scenes that differ in what the contacts do. Each is a case without harmonics, the harmonics to try, and those of its reference."""

import sys
import tomllib
from dataclasses import dataclass

from measure import ROOT, weigh

sys.path.insert(0, str(ROOT / "tests/verification"))
import cases
import points

POSTS = ROOT / "inputs/two_solids"


@dataclass
class Scene:
    kind: str
    make: object  # (folder) -> content of the case as a dict, with files by absolute paths
    harmonics: tuple
    reference: int
    modes: tuple = ()  # of the reduction, to try with few harmonics; the last is the reference
    choose_modes: bool = False  # try tolerances that choose modes, too
    one_of_several: bool = False  # motions are possible: all runs begin at the reference's


def posts(force):
    """The two posts of inputs/two_solids under another force."""
    def make(_):
        if not (POSTS / "model.h5").exists():
            weigh([sys.executable, POSTS / "model.py"])
        content = tomllib.loads((POSTS / "case.toml").read_text())
        content["model"] = str(POSTS / "model.h5")
        content["excitation"]["fourier"] = [0, 0, force]
        content["harmonic_balance"] = {"solver": "modal"}
        return content
    return make


def small(function, *arguments, **keys):
    """One of the structures of the verification tests."""
    def make(folder):
        path = function(folder, *arguments, samples=None, adaptive=True, step=0.02, kind="auto", **keys).path
        content = tomllib.loads(path.read_text())
        key = "model" if "model" in content else "reduced"
        content[key] = str(path.parent / content[key])
        return content
    return make


def blade(folder):
    return tomllib.loads(points.blade_case(folder, 102, 5, "modal").read_text())


SCENES = {
    "stuck": Scene("sticks, or is open, all the time", posts(0.5), (1, 3, 5), 20, (1, 2, 5, 10, 20, 60), True),
    "partial slip": Scene("two posts: some of nine points slip", posts(5), (1, 3, 5, 7, 10, 15, 20, 30), 60,
                          (1, 2, 5, 10, 20, 60), True),
    "gross slip": Scene("one point slides nearly all the time", small(cases.dof5, friction=[0.25, 0.25], omega=[0.9, 1.3]),
                        (1, 3, 5, 7, 10, 15, 20), 60),
    "lift-off": Scene("one point slips and lifts off", small(cases.single_mass, 2, omega=[13, 11.6]),
                      (3, 5, 7, 10, 15, 20), 60),
    "stiff impact": Scene("bounces on a contact 100 times as stiff", small(
        cases.single_mass, 1, omega=[14, 12.1], normal_stiffness=4000.0, fourier=[0, 0, 9]), (5, 10, 15, 20, 30, 40), 100,
        one_of_several=True),
    "blade root": Scene("102 points, most of them slip", blade, (1, 3, 5, 7, 10, 20, 40), 48, (2, 4, 12, 30, 80)),
    "three harmonics": Scene("four points slip and lift off", small(
        cases.several_points, fourier=[0.2, 1, 0.5, 0, 0.3, 0.3, 0.2], omega=[0.8, 1.2]), (3, 5, 7, 10, 15, 20), 50),
}
