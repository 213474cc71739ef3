"""The structures of the verification tests: each as arrays for the reference, and as files for `dovetail run`.

Every function writes model.h5 or reduced.h5 and case.toml into a folder and returns a `Case`. Keyword overrides are named
as the keys of the case file: `dof5(folder, harmonics=3, samples=32, omega=[1, 1.1], kind="auto")`.
"""

import json
import shutil
from dataclasses import dataclass, field, replace
from pathlib import Path

import h5py
import numpy as np
import scipy.linalg

from dovetail import Model, reference

SECTION_OF = {
    "modes": "reduction", "stiffness": "damping", "mass": "damping", "structural": "damping", "ratios": "damping",
    "of": "damping", "matrix": "damping", "damped_springs": "damping", "fourier": "excitation",
    "normal_stiffness": "contact", "tangential_stiffness": "contact", "friction": "contact", "gap": "contact",
    "law": "contact",
    "initial": "preload", "harmonics": "harmonic_balance", "samples": "harmonic_balance",
    "solver": "harmonic_balance",
    "step_tolerance": "newton", "residual_tolerance": "newton", "max_iterations": "newton",
    "kind": "scaling", "frequency": "scaling", "modal": "scaling", "contact": "scaling",
    "omega": "continuation", "step": "continuation", "adaptive": "continuation", "max_points": "continuation",
    "at": "continuation", "unit": "continuation", "tolerance": "accuracy", "estimates": "accuracy", "between": "accuracy",
    "enabled": "stability",
}
NAME_OF = {"damped_springs": "contact"}  # where a key has that name in two sections
TIGHT = {"step_tolerance": 1e-10, "residual_tolerance": 1e-10}
ENDLESS = {"adaptive": False, "step": 1e-5, "max_points": 10**6}  # minutes of points: more than any test waits for, however late it wakes


@dataclass
class Structure:
    """Arguments of `reference.craig_bampton`, without the number of modes."""

    K: np.ndarray
    M: np.ndarray
    contact_dofs: np.ndarray
    force: np.ndarray  # (n,), or (patterns, n)
    preload: np.ndarray
    matrices: dict = field(default_factory=dict)  # C, K_structural (n, n)

    def static_state(self, xp):
        """Displacements (n,) of the whole structure under its preload, contact points held at xp (N_x, 3) [m]."""
        e, c, K, _ = reference.split(self.K, self.M, self.contact_dofs)
        u = np.empty(len(K))
        u[c] = xp.ravel()
        u[e] = np.linalg.solve(K[np.ix_(e, e)], self.preload[e] - K[np.ix_(e, c)] @ u[c])
        return u


@dataclass
class Case:
    """A case in a folder, and the same thing for the reference. `structure` is None for a reduced model."""

    path: Path
    structure: Structure
    reduced: reference.Reduced
    settings: dict

    def edit(self, old, new):
        text = self.path.read_text()
        assert old in text
        self.path.write_text(text.replace(old, new))

    def copied(self, folder, without=()):
        """The same case in another folder, with all files beside it but those named."""
        shutil.copytree(self.path.parent, folder, ignore=shutil.ignore_patterns(*without))
        return replace(self, path=folder / self.path.name)

    @property
    def contact(self):
        keys = ("normal_stiffness", "tangential_stiffness", "friction", "gap")
        return reference.Contact.uniform(len(self.reduced.r) // 3, *(self.settings[key] for key in keys),
                                         law=self.settings.get("law", "coulomb"))

    @property
    def preload(self):
        return reference.contact_preload(self.reduced, self.contact, self.settings["initial"])

    def system(self, harmonics=None, samples=None):
        """The reference's equations, by default with the harmonics and samples of the case."""
        s = self.settings
        courses = list(s["loads"].values()) if "loads" in s else s["fourier"]
        return reference.HarmonicBalance(self.reduced, self.contact, self.preload, self.damping(), courses,
                                         harmonics or s["harmonics"], samples or s["samples"])

    def damping(self):
        """Every kind of [damping], each by its definition, in the unknowns of the reduced model."""
        s, structure, modes = self.settings, self.structure, len(self.reduced.kaa)
        proportional = s["stiffness"], s.get("mass", 0.0), s.get("structural", 0.0)
        matrix = 0.0
        springs = np.r_[np.zeros(modes), np.column_stack([self.contact.kt, self.contact.kn]).ravel()]
        if "ratios" in s and s.get("of") == "fixed":
            rates = np.zeros(modes + len(self.reduced.r))
            for mode, ratio in s["ratios"]:
                rates[mode - 1] = 2 * ratio * np.sqrt(self.reduced.kaa[mode - 1])
            matrix = np.diag(rates)
        elif "ratios" in s:
            plain = reference.HarmonicBalance(self.reduced, self.contact, self.preload, 0.0, [0], 1, 8)
            squares, shapes = scipy.linalg.eigh(plain.K + np.diag(springs), plain.M)
            rates = np.zeros(len(squares))
            for mode, ratio in s["ratios"]:
                rates[mode - 1] = 2 * ratio * np.sqrt(squares[mode - 1])
            matrix = plain.M @ shapes @ np.diag(rates) @ shapes.T @ plain.M
        if s.get("damped_springs"):
            normal = self.preload.g[:, 2:]
            sticks = np.abs(self.preload.g[:, :2]) < self.contact.mu * normal * (1 - 1e-9)
            closed = np.column_stack([sticks, normal > 0]) * np.column_stack([self.contact.kt, self.contact.kn])
            matrix = matrix + s["stiffness"] * np.diag(np.r_[np.zeros(modes), closed.ravel()])

        def projected(name):
            return reference.projected(structure.matrices[name], structure.K, structure.M, structure.contact_dofs, modes)
        if s.get("matrix"):
            matrix = matrix + projected("C")
        given = structure is not None and "K_structural" in structure.matrices
        return reference.Damping(*proportional, matrix, projected("K_structural") if given else None)


def dof5(folder, force=(1.0, 1, 0, 0, 0), **overrides):
    """The five-degree-of-freedom example with one contact point, as its authors deliver it."""
    structure = Structure(K=20 * np.eye(5) - 10 * np.eye(5, k=1) - 10 * np.eye(5, k=-1), M=np.eye(5),
                          contact_dofs=np.array([[2, 3, 4]]), force=np.array(force),
                          preload=np.array([1, 0.1, 0.1, 0.1, 0.1]))
    structure.K[0, 0] = 10
    return full(folder, "five degrees of freedom", structure, overrides, modes=2, stiffness=0.05, fourier=[0, 0, 1, 0, 0],
                normal_stiffness=1.0, tangential_stiffness=[1.0, 1.0], friction=[1.0, 1.0], gap=-3.5, initial=1e-5,
                harmonics=10, samples=64, step_tolerance=1e-5, residual_tolerance=1e-5, omega=[0.9, 1.3], step=0.05)


def single_mass(folder, check, **overrides):
    """One mass on springs pressed onto one contact point; check 1 excites it normally, check 2 also tangentially.

    N_a = 1 is a dummy mode that nothing couples or excites.
    """
    force = np.array([0.0, 0, 100]) if check == 1 else np.array([100.0, 0, 100])
    reduced = reference.Reduced(kaa=np.ones(1), max=np.zeros((1, 3)), mxx=np.eye(3), kxx=40 * np.eye(3), fa=np.zeros(1),
                                fx=force, r=np.array([0.0, 0, -800]))
    write_reduced(folder, reduced)
    return write(folder, f"single mass, check {check}", "reduced.h5", None, reduced, overrides, stiffness=0.01,
                 fourier=[0, 0, 1], normal_stiffness=120.0, tangential_stiffness=30.0, friction=0.3 if check == 1 else 8.0,
                 gap=0.0, initial=0.0, harmonics=10, samples=256, omega=[5, 16], step=0.5, kind="none", **TIGHT)


def stuck_mass(folder):
    """One mass that never slips: C = b K of its own spring k, and k_t of the contact besides."""
    case = single_mass(folder, 2, friction=1e4, tangential_stiffness=60.0, omega=[7, 13.5], harmonics=1, samples="exact",
                       solver="modal", kind="auto")
    with h5py.File(folder / "reduced.h5", "r+") as file:
        file["Fx"][...] = [1.0, 0, 0]
    return case


def random_structure(elastic=12, points=4, seed=7):
    """Structure with full matrices, eigenfrequencies from 1 to 6 rad/s, and contact dofs scattered among the others."""
    rng = np.random.default_rng(seed)
    n = elastic + 3 * points
    basis = np.linalg.qr(rng.normal(size=(n, n)))[0]
    mixing = np.eye(n) + 0.2 * basis[:, ::-1] @ np.diag(rng.uniform(0, 1, n)) @ basis[:, ::-1].T
    K = mixing @ basis @ np.diag(np.linspace(1, 6, n) ** 2) @ basis.T @ mixing
    dofs = rng.permutation(n)[:3 * points].reshape(points, 3)
    preload = 0.3 * rng.normal(size=n)
    preload[dofs[:, 2]] = 4
    return Structure((K + K.T) / 2, mixing @ mixing, dofs, rng.normal(size=n), preload)


def several_points(folder, elastic=12, structure=None, **overrides):
    """Four contact points with different parameters, of which some slip and some lift off near the first resonance."""
    return full(folder, "random structure", structure or random_structure(elastic), overrides, modes=5, stiffness=0.02,
                fourier=[0.2, 1, 0.5, 0, 0.3], normal_stiffness=[3.0, 4.0, 5.0, 6.0],
                tangential_stiffness=[[1.0, 2.0], [2.0, 1.0], [1.5, 1.5], [3.0, 2.0]],
                friction=[[0.3, 0.4], [0.2, 0.3], [0.5, 0.6], [0.4, 0.2]], gap=[-0.1, 0.0, -0.2, 0.1], initial=0.0,
                harmonics=5, samples=64, omega=[0.8, 1.6], step=0.05, **TIGHT)


def always_open(folder, **overrides):
    """A linear case: the contacts stay open, and all modes are kept, so that the full model's response is exact."""
    return full(folder, "contacts never touch", random_structure(), overrides, modes=12, stiffness=0.02,
                fourier=[0.2, 1, 0.5, 0, 0.3], normal_stiffness=5.0, tangential_stiffness=2.0, friction=0.5, gap=1e3,
                initial=0.0, harmonics=3, samples=32, omega=[0.8, 1.6], step=0.1, **TIGHT)


def always_stuck(folder, **overrides):
    """A linear case: the contacts stay closed and never slip, so that they act as springs."""
    return full(folder, "contacts never slip", random_structure(), overrides, modes=12, stiffness=0.02,
                fourier=[0.2, 1, 0.5, 0, 0.3], normal_stiffness=5.0, tangential_stiffness=[2.0, 3.0], friction=1e3, gap=-1e3,
                initial=0.0, harmonics=3, samples=32, omega=[0.8, 1.6], step=0.1, **TIGHT)


def full(folder, title, structure, overrides, **settings):
    """A case that starts from a full model. `loads`: names of the patterns of `structure.force`, with their courses."""
    loads = overrides.get("loads", settings.get("loads"))
    force = {"force": structure.force} if loads is None else {"forces": dict(zip(loads, structure.force, strict=True))}
    Model(structure.K, structure.M, structure.contact_dofs, preload=structure.preload, **force,
          **structure.matrices).write(Path(folder) / "model.h5")
    modes = overrides.get("modes", settings["modes"])
    reduced = None if modes is None else reference.craig_bampton(structure.K, structure.M, structure.contact_dofs,
                                                                 structure.force, structure.preload, modes)
    return write(folder, title, "model.h5", structure, reduced, overrides, **{"kind": "none", **settings})


def write_reduced(folder, reduced):
    """reduced.h5 with the arrays of a `reference.Reduced`."""
    with h5py.File(Path(folder) / "reduced.h5", "w") as file:
        for name, values in (("Kaa", reduced.kaa), ("Max", reduced.max), ("Mxx", reduced.mxx), ("Kxx", reduced.kxx),
                             ("Fa", reduced.fa), ("Fx", reduced.fx), ("R", reduced.r)):
            file[name] = values
        file.attrs["format"], file.attrs["version"] = "dovetail-reduced", 1


def write(folder, title, model, structure, reduced, overrides, **settings):
    """Write case.toml: `settings` with `overrides`; None leaves a key out."""
    settings.update(overrides)
    settings = {key: value for key, value in settings.items() if value is not None}
    loads = settings.get("loads", {})
    sections = {}
    for key, value in settings.items():
        if key == "loads" or loads and key == "fourier":
            continue
        sections.setdefault(SECTION_OF[key], []).append(f"{NAME_OF.get(key, key)} = {json.dumps(value)}")
    lines = [f'title = "{title}"', f'{Path(model).stem} = "{model}"']
    for name, entries in sections.items():
        lines += ["", f"[{name}]", *entries]
    for name, course in loads.items():
        lines += ["", "[[excitation.load]]", f'pattern = "{name}"', f"fourier = {json.dumps(course)}"]
    path = Path(folder) / "case.toml"
    path.write_text("\n".join(lines) + "\n")
    return Case(path, structure, reduced, settings)
