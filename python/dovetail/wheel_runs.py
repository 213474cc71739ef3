"""The program on all sectors of a wheel: a reduced file of the whole, and a case for a point of a travelling wave."""

import tomllib
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np

from .case_runs import COPY, need_own
from .hdf5_read import opened
from .output_files import made
from .recovery import reduced_file
from .reduced_system import courses_of
from .reference import LAWS
from .results import Results
from .study_runs import Program, Run, RunFailed, compute, toml
from .travelling_wave import TravellingWave, spatial_index
from .wheel_model import unrolled, wave_of_wheel, write_reduced

CONTACT_UNKNOWNS = 8000  # 3 N N_x (2H+1), which the program's stability factors as one dense matrix: 0.5 GiB, twice over
CONTACT_DOFS = 8000  # 3 N N_x, of two dense matrices: 1 GiB, and 1.5 more for their sums while they are made
KEPT = ("damping", "newton", "scaling")  # sections of the case that are as well those of the wheel
HEAD = COPY + "# The whole wheel of a sector, in coordinates that follow from its modes; it begins with the travelling wave, start.h5.\n"


@dataclass(frozen=True)
class Told:
    """`stable` and `multiplier` of `Results`, None where the wheel is too large for its stability; moved: by how much the program's own
    solution has other contact motions, relative."""

    stable: int | None
    multiplier: float | None
    moved: float


class WholeWheel:
    """The wheel of a sector's results, in a folder, for some points of them. Default: NAME_wheel beside the results NAME.h5."""

    def __init__(self, results, points, out=None, binary=None):
        self.results, self.program = results, Program(binary)
        self.folder = Path(out) if out else results.path.with_name(f"{results.path.stem}_wheel")
        N, widest = results.wave.sectors, 2 * int(results.points("harmonics")[points].max()) + 1
        dofs = 3 * N * results.contact_points
        if dofs > CONTACT_DOFS:
            raise ValueError(f"--whole: {N} sectors with {results.contact_points} contact points have {dofs} contact dofs, "
                             f"{CONTACT_DOFS} are the limit, two matrices of 0.5 GiB; without --whole the sector tells it")
        self.judged = dofs * widest <= CONTACT_UNKNOWNS
        for point in points:
            need_own(self.folder_of(point))
        with opened(reduced_file(results)) as file:
            self.wheel = unrolled(file, results)
        write_reduced(made(self.folder / "reduced.h5"), self.wheel, results.units)

    def folder_of(self, point):
        return self.folder / f"point_{point}"

    def run(self, point):
        """What the program Told of a point."""
        folder, width = self.folder_of(point), 2 * int(self.results.points("harmonics")[point]) + 1
        start = wave_of_wheel(self.results.wave, self.results.coefficients_at(point), self.results.modes, self.wheel.phases)[:, :width]
        with h5py.File(made(folder / "start.h5"), "w") as file:
            file.attrs["format"], file.attrs["version"] = "dovetail-results", 1
            file["points/omega"], file["points/coefficients"] = [self.results.omega[point]], start[None]
        run = Run(None, folder, HEAD + toml(self.case(point, width)), f"point {point} of {self.results.path}")
        for _ in compute([run], self.program, 1, lambda _: None):
            pass
        if run.status:
            raise RunFailed(f"{folder / 'case.toml'}: {run.reason}", run.status)
        done, modes = Results(folder / "results.h5"), len(self.wheel.reduced.kaa)
        moved = np.abs(done.coefficients_at(0)[modes:] - start[modes:]).max() / np.abs(start[modes:]).max()
        judged = (int(done.stable[0]), float(done.points("multiplier")[0])) if self.judged else (None, None)
        return Told(*judged, float(moved))

    def case(self, point, width):
        """The case of the wheel at a point, with coefficients [a0, a1, b1, ...] of that width."""
        results, given = self.results, tomllib.loads(self.results.case)
        wave, omega, contact = results.wave, float(results.omega[point]), results.contact
        wave = TravellingWave(wave.sectors, wave.engine_order, spatial_index(width // 2, wave.engine_order, wave.sectors))
        loads, courses = [], courses_of(results)
        for name, j in self.wheel.loads:
            if name not in courses:  # a pattern of the model that rests in the case
                continue
            course = np.zeros(width)
            series = courses[name][:width]
            course[:len(series)] = series
            loads.append({"pattern": f"{name}_{j}", "fourier": wave.of_sector(course, j).tolist()})
        values = {key: np.concatenate([contact[key]] * wave.sectors).tolist() for key in ("normal_stiffness", "gap")}
        values["law"] = [LAWS[number] for number in contact["law"]] * wave.sectors
        rubs = (contact["law"] <= 1)[:, None]
        if rubs.any():  # 1 has no meaning where there is no friction, and must be positive
            values |= {key: np.concatenate([np.where(rubs, contact[key], 1.0)] * wave.sectors).tolist()
                       for key in ("tangential_stiffness", "friction")}
        balance = {"harmonics": width // 2} | ({"samples": results.samples} if results.samples else {})
        return {"title": f"{results.title}, whole wheel".removeprefix(", "), "reduced": "../reduced.h5"} | {
            key: given[key] for key in KEPT if key in given} | {
            "excitation": {"load": loads}, "contact": values, "preload": {"initial": np.tile(results.xp, wave.sectors).tolist()},
            "harmonic_balance": balance, "continuation": {"omega": [omega, omega], "start": "start.h5"},
            "accuracy": {"estimates": False}, "stability": {"enabled": self.judged}}
