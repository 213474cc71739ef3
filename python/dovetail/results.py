"""Read a results file: amplitudes, time histories, contact forces, hysteresis loops, fields of the full model."""

import re
from functools import cache, cached_property
from pathlib import Path

import numpy as np

from . import contact_motion, curves, fourier, recovery, units
from .checked import finite_number, whole_number
from .events import read_events
from .hdf5_read import dataset, members, numbers, patiently, whole, words
from .parameters import CONTACT_WIDTH
from .reference import LAWS
from .sensitivity import read_sensitivity
from .travelling_wave import along, read_wave

VERSION = 1  # of the format
DIRECTIONS = ("t1", "t2", "n")
NEEDED = ("omega", "arclength", "newton_iterations", "seconds", "stick", "slip", "open")  # of /points
OF_MODES = ("modal_amplitude", "damping_ratio", "friction_energy", "force_level", "energy_error")
MODAL = "m kg^1/2"  # unit of modal amplitudes in the SI
ESTIMATED = ("error_harmonics", "error_sampling", "error_modes")
JUDGED = {"stable": "i", "multiplier": "f", "instability": "i"}
BLOCK = 1 << 23  # numbers of coefficients in memory at a time


STABLE, UNSTABLE, UNCERTAIN = 1, 0, -1
INSTABILITIES = ("none", "jump", "period doubling", "second frequency")


class Results:
    """A response branch, finished or still being computed.

    Every number is in the user's own units. Coefficients are measured from the preload state
    (docs/theory/equations.md, section 4).
    `point` below is the zero-based index of a point of the branch (see `at`, `peak_point`); `contact` is the one-based number
    of a contact point, as in the name "x3.t1". `dof` is the name of an unknown, "a1" or "x3.n", or of the motion of a node:
    "tip.y", with a node set of the model (the mean of its nodes) or the row of a node, and x, y or z.

    Parameters
    ----------
    path : path-like
    model : path-like, optional
        The model file, for nodes; default the one that the reduced file names.

    Attributes
    ----------
    omega : (n,) array
        Excitation frequency in units of the model, [rad/s] in SI; `frequency` is the same in Hz.
    parameter : (n,) array or None
        Of a sweep over another parameter than the frequency, its value at every point; `parameter_name` is its name in the case
        file, `parameter_unit` "-" for a factor on what the case has. Of a nonlinear mode, the modal amplitude.
    tracked_amplitude : (n,) array or None
        Of peaks that are followed over a parameter, sqrt(sum of a_k^2 + b_k^2, k >= 1) of what is watched, which is largest there.
    modal_amplitude, damping_ratio, friction_energy, force_level, energy_error : (n,) arrays or None
        Of a nonlinear mode ([mode]), whose `omega` is its frequency: amplitude [m kg^1/2], damping ratio of the resonance,
        energy that the contacts dissipate per period [J], multiple of the load at whose resonance it is the response (inf where
        the load does no work on it), and by how much energies fail to balance, as a damping ratio. None of other runs.
    harmonics, samples, modes, contact_points : int
        H, N, N_a, N_x; N is 0 where contact forces were evaluated exactly, without samples. H is the largest of any point: a run
        may add harmonics on its way; `points("harmonics")` holds those of each, the rest of its coefficients is zero.
    stable : (n,) int array or None
        STABLE, UNSTABLE or UNCERTAIN; None where the run did not ask. `multiplier` is the largest modulus of a Floquet multiplier,
        `instability` the number of a name in INSTABILITIES.
    wave : travelling_wave.TravellingWave or None
        Of a sector of a cyclic structure: `sectors`, `engine_order`, `index`, the signed nodal diameter of every harmonic, and
        `frequencies` [rad/s] of the stuck structure by nodal diameter. All numbers here are those of sector 0 unless `sector` is
        given, and vectors are counted in axes turned along with the sector.
    error : (n,) array or None
        Estimated distance of every point from the curve that enough harmonics and samples would give, relative; NaN where there is
        none, None where the run did not ask. See docs/theory/error-estimates.md.
    events : Events
    sensitivity : Sensitivity or None
        What the located peaks depend on; None where `[sensitivity]` was not given.
    drawing_samples : int
        Instants per period at which contact forces are evaluated here unless another number is asked for.
    contact : dict
        `law` (N_x,), numbers of the names in `reference.LAWS`; `normal_stiffness` (N_x,), `tangential_stiffness` (N_x, 2),
        `friction` (N_x, 2), `gap` (N_x,).
    xp, g, w : (3 N_x,), (3 N_x,), (N_x, 2) arrays
        Displacement, force and slider positions of the preload state, equation (7).
    title, case, units : str
    unit : units.Units
        What `units` stands for: names for axes and numbers, empty where it is not understood.
    watch : str
        The unknown of `continuation.watch`; empty where the case names none.
    """

    def __init__(self, path, model=None):
        self.path, self.model, self._node_rows, self._at_rest = Path(path), model, {}, {}
        self._read(self._load_header)

    def _load_header(self, file):
        kind = words(file, "format", "unnamed")
        if kind != "dovetail-results":
            raise ValueError(f"format must be dovetail-results, found {kind}")
        if "version" in file.attrs and (version := whole(file, "version")) != VERSION:
            raise ValueError(f"version {version} of the results format; this package reads version {VERSION}")
        self.title, self.case, self.units = words(file, "title"), words(file, "case"), words(file, "units", "SI")
        self.parameter_name, self.parameter_unit = words(file, "parameter"), words(file, "parameter_unit")
        self.unit, self.watch = units.parse(self.units), words(file, "watch")
        self.harmonics, self.samples, self.modes, self.contact_points = (
            whole(file, key) for key in ("harmonics", "samples", "modes", "contact_points"))
        reduced = words(file, "reduced")
        self.reduced = self.path.parent / reduced if reduced else None
        self.reduced_fingerprint = words(file, "reduced_fingerprint")
        self._load_contact(file)
        dofs, width = self.modes + 3 * self.contact_points, 2 * self.harmonics + 1
        found = dataset(file, "points/coefficients", (None, dofs, None)).shape[2]
        if found < width or found % 2 == 0:
            dataset(file, "points/coefficients", (None, dofs, width))
        self.harmonics = found // 2  # a run that adds harmonics widens the table before it sets the attribute
        self.wave = read_wave(file, self.harmonics)
        self.drawing_samples = self.samples or max(256, 1 << (40 * self.harmonics).bit_length())
        for name in NEEDED:
            dataset(file, f"points/{name}", (None,))
        points = {name: dataset(file, f"points/{name}", (None, ...)) for name in file["points"] if name != "contact"}
        activity = [dataset(file, f"points/contact/{name}", (None, self.contact_points)) for name in members(file, "points/contact")]
        self._n = min(len(values) for values in (*points.values(), *activity))
        self._has_tangents = "tangent" in points and "tangent_parameter" in points
        if self._has_tangents:
            dataset(file, "points/tangent", (None, dofs, found))
        self._points = {name: values[:self._n] for name, values in points.items() if values.ndim == 1}
        for name in ("omega", "arclength"):
            self._points[name] = self._points[name].astype(np.float64)
            if not np.all(np.isfinite(self._points[name])):
                raise ValueError(f"/points/{name} is not finite everywhere")
        self.omega, self.tracked_amplitude = self._points["omega"], self._points.get("tracked_amplitude")
        self.modal_amplitude, self.damping_ratio, self.friction_energy, self.force_level, self.energy_error = (
            self._points.get(name) for name in OF_MODES)
        self.parameter = self._points.get("parameter", self.modal_amplitude)
        self.stable = self.multiplier = self.instability = None
        if "stable" in points:
            self.stable, self.multiplier, self.instability = (
                numbers(file, f"points/{name}", (None,), kind)[:self._n] for name, kind in JUDGED.items())
        errors = [self._points[name].astype(np.float64) for name in ESTIMATED if name in points]  # not all are known of every run
        self.error = sum(errors) if errors else None
        self.has_activity = bool(activity)
        self.events = read_events(file, self._n, dofs, self.parameter is not None)
        self.sensitivity = read_sensitivity(file, self._n, self.contact, self)

    def _load_contact(self, file):
        n, self.contact = self.contact_points, {"law": np.zeros(self.contact_points, int)}  # older files know one law
        if "contact/law" in file:
            self.contact["law"] = numbers(file, "contact/law", (n,), "i")
            if np.any((self.contact["law"] < 0) | (self.contact["law"] >= len(LAWS))):
                raise ValueError(f"/contact/law must hold numbers from 0 to {len(LAWS) - 1}")
        for name, width in CONTACT_WIDTH.items():
            self.contact[name] = numbers(file, f"contact/{name}", (n,) if width == 1 else (n, width))
        self.xp, self.g = (numbers(file, f"preload/{name}", (3 * n,)) for name in ("xp", "g"))
        self.w = numbers(file, "preload/w", (n, 2))

    def _read(self, function):
        return patiently(self.path, function)

    def __len__(self) -> int:
        return self._n

    @property
    def frequency(self) -> np.ndarray:
        """Excitation frequency [Hz], (n,)."""
        return self.unit.hertz(self.omega)

    @cached_property
    def coefficients(self) -> np.ndarray:
        """All coefficients, (n, N_a + 3 N_x, 2H+1); modal unknowns first, then t1, t2, n of each contact point."""
        return self._coefficients(slice(self._n))

    def points(self, name: str) -> np.ndarray:
        """A quantity stored per point, (n,): arclength, newton_iterations, residual, seconds, stick, slip, open, ..."""
        if name not in self._points:
            raise KeyError(f"no quantity {name!r} per point; there are {', '.join(sorted(self._points))}")
        return self._points[name]

    def dof_names(self) -> list[str]:
        """Names of all unknowns in the order of `coefficients`: a1, a2, ..., x1.t1, x1.t2, x1.n, x2.t1, ..."""
        return [f"a{j + 1}" for j in range(self.modes)] + [f"x{j + 1}.{d}" for j in range(self.contact_points) for d in DIRECTIONS]

    def dof_index(self, name: str | int) -> int:
        """Row in `coefficients` of a degree of freedom: "a1", "x3.n" (numbers from one), or the row itself."""
        if isinstance(name, (int, np.integer)):
            if 0 <= name < self.modes + 3 * self.contact_points:
                return int(name)
        else:
            match = re.fullmatch(r"a(\d+)|x(\d+)\.(t1|t2|n)", str(name))
            if match and match[1] and 1 <= int(match[1]) <= self.modes:
                return int(match[1]) - 1
            if match and match[2] and 1 <= int(match[2]) <= self.contact_points:
                return self.modes + 3 * (int(match[2]) - 1) + DIRECTIONS.index(match[3])
        modes = f"a1 to a{self.modes}, and " if self.modes else ""
        raise KeyError(f"no degree of freedom {name!r}; there are {modes}x1 to x{self.contact_points} each with .t1, .t2 and .n, "
                       "and node sets or nodes of the model with .x, .y and .z")

    def unit_of(self, dof: str | int) -> str:
        """Name of the unit of an unknown or a node's motion; empty where units are not known."""
        return self.unit.modal if curves.is_reduced(dof) and self.dof_index(dof) < self.modes else self.unit.length

    @cached_property
    def watched(self) -> str:
        """Name of the unknown whose peaks the run names: that of `continuation.watch`, else the one that moves most at the largest
        of them, or, where there is none, anywhere."""
        if self.watch:
            return self.watch
        peaks = self.events.of("peak")
        if np.any(peaks.unknown >= 0):
            return self.dof_names()[peaks.unknown[np.argmax(np.where(peaks.unknown >= 0, peaks.amplitude, -1.0))]]
        first = self.modes if self.contact_points else 0
        return self.dof_names()[first + curves.moves_most(self.coefficients[:, first:])]

    @property
    def along(self) -> np.ndarray:
        """What the branch is followed over, (n,): `omega`, or `parameter` where that is another."""
        return self.omega if self.parameter is None else self.parameter

    @property
    def along_unit(self) -> str:
        """Its unit, "" for a factor on what the case has."""
        if self.parameter is None:
            return self.unit.omega
        return {"m": self.unit.length, MODAL: self.unit.modal}.get(self.parameter_unit, "")

    def place(self, value: float, digits: int = 9) -> str:
        """A value of `along` in words: "1.3 rad/s", "friction 0.5", or "gap 1e-6 m"."""
        name = "" if self.parameter is None else f"{self.parameter_name} "
        return units.with_unit(f"{name}{value:.{digits}g}", self.along_unit)

    def at(self, value: float) -> int:
        """Index of the point nearest to a value of `along`, omega [rad/s]; the first one where the branch passes it several times."""
        self.need_points()
        return int(np.argmin(np.abs(self.along - finite_number(value, "value"))))

    def amplitude(self, dof: str | int | None = None) -> np.ndarray:
        """Half the peak-to-peak of the motion over the period at every point, (n,), of the trigonometric polynomial (not of samples).

        The mean does not count.
        """
        return self._curve_of(dof).amplitude

    def response(self, dof: str | int | list | None = None) -> curves.Response | list[curves.Response]:
        """The curve of an unknown or of a node, a `curves.Response`; of a list of names, a list of them; default: what is watched.

        What follows is computed from it: who wants several of these of one unknown asks for the curve once.
        """
        if isinstance(dof, (list, tuple)):
            return [self.response(name) for name in dof]
        dof = self.watched if dof is None else dof
        coefficients = self._of_dof(dof)
        return curves.Response(str(dof), self.unit_of(dof), self.omega, self.frequency, self.along, self.points("arclength"),
                               fourier.amplitude(coefficients), coefficients, self.jumps, self.located_peaks(dof),
                               self._slopes_of(dof) if self._has_tangents else None,
                               np.flatnonzero(np.diff(self.points("harmonics"))) if self._has_tangents else (),
                               self._points.get("tangent_omega"))

    def _curve_of(self, dof):
        if isinstance(dof, (list, tuple)):
            raise ValueError(f"one unknown or node is wanted, found {dof!r}; response() takes several")
        return self.response(dof)

    def curve(self, dof: str | int | None = None, n: int = curves.DRAWN) -> tuple[np.ndarray, np.ndarray]:
        """(along, amplitude) of an unknown or a node as the curve is drawn, n values from each point to the next: `Response.curve`."""
        return self._curve_of(dof).curve(n)

    def _slopes_of(self, dof):
        """`Response.slopes`: read when they are wanted."""
        return cache(lambda: (self.points("tangent_parameter"), self._of_dof(dof, name="points/tangent")))

    def harmonic(self, dof: str | int, k: int) -> np.ndarray:
        """Amplitude sqrt(a_k^2 + b_k^2) of harmonic k at every point, (n,); |a0|/2 for k = 0."""
        return self._curve_of(dof).harmonic(k)

    @property
    def jumps(self) -> np.ndarray:
        """Numbers of the points behind which the branch goes on elsewhere: after a leap, or a stay outside the sweep."""
        return np.unique(self.events.of(*curves.JUMPS).point)

    def peaks(self, dof: str | int | None = None) -> list[tuple[float, float]]:
        """(omega, amplitude) of each peak, in the order of the branch: local maxima strictly inside it, as an end is no peak.

        Over another parameter than the frequency, its value in place of omega. A peak that the run has located is that point. Others
        are maxima of the curve as it is drawn between points, by cubics over arc length; of runs that store no tangents, of a
        parabola through a point and its two neighbours. A curve that leans over is no trouble.
        """
        return self._curve_of(dof).peaks()

    def peak(self, dof: str | int | None = None) -> tuple[float, float]:
        """(omega, amplitude) of the largest of `peaks`. Raises ValueError where there is none: an end of the sweep is no peak."""
        curve = self._curve_of(dof)
        return max(curve.peaks() or self._refuse_no_peak(curve), key=lambda peak: peak[1])

    def peak_point(self, dof: str | int | None = None) -> int:
        """Index of the point with the largest amplitude of those that are peaks. Raises ValueError where there is none."""
        curve = self._curve_of(dof)
        point = curve.peak_point()
        return self._refuse_no_peak(curve) if point is None else point

    def largest_point(self, dof: str | int | None = None) -> int:
        """Index of the point with the largest amplitude, be it a peak or an end of the branch."""
        self.need_points()
        return self._curve_of(dof).largest_point()

    def ends(self, dof: str | int | None = None) -> list[tuple[float, float, str]]:
        """(omega, amplitude, words) where the amplitude rises towards an end of the branch, so that a peak may lie beyond."""
        return self._curve_of(dof).ends()

    def located_peaks(self, dof: str | int) -> np.ndarray:
        """Points that the run has located as maxima of this unknown or node: where it was the one watched, or moved most."""
        peaks = self.events.of("peak")
        if curves.is_reduced(dof):
            return peaks.point[peaks.unknown == self.dof_index(dof)]
        return peaks.point[(peaks.unknown == -1) & (self.watch == dof)]

    def columns(self, dofs: list | str | None = None) -> dict[str, np.ndarray]:
        """A table by name, a value per point in each: omega, frequency [Hz], the parameter, amplitudes (half the peak-to-peak) of the dofs
        by names, a list or one (default: what is watched), stick, slip, open, and what else the run has: friction_energy [J] per period,
        damping_ratio, force_level, stable, multiplier, error."""
        from .frames import columns_of

        return columns_of(self, dofs)

    def to_frame(self, dofs: list | str | None = None):
        """`columns` as a pandas.DataFrame, one row per point. Raises ImportError where there is no pandas."""
        from .frames import frame

        return frame(self.columns(dofs))

    def time_history(self, point: int, dof: str | int, n: int = 256, sector: int | None = None) -> tuple[np.ndarray, np.ndarray]:
        """One period of a degree of freedom: time [s] and value, both (n,), without the end point."""
        i = self.number(point)
        coefficients = self._in_sector(self._of_dof(dof, slice(i, i + 1))[0], sector)
        theta = fourier.phases(n)
        return theta / self.omega[point], fourier.basis(self.harmonics, theta) @ coefficients

    def contact_force(self, point: int, contact: int, n: int | None = None, sector: int | None = None) -> tuple[np.ndarray, np.ndarray]:
        """Total force g(x + x_p) of a contact point over the period; see `contact_motion.force`."""
        return contact_motion.force(self, point, contact, n, sector)

    def hysteresis(self, point: int, contact: int, direction: int = 0, n: int | None = None,
                   sector: int | None = None) -> tuple[np.ndarray, np.ndarray]:
        """A friction loop: total tangential displacement x + x_p [m] and force T [N] over one period, both (n,).

        direction is 0 for t1, 1 for t2; sector the number of a sector of a cyclic structure, default 0.
        """
        return contact_motion.hysteresis(self, point, contact, direction, n, sector)

    def contact_activity(self, point: int | None = None) -> contact_motion.ContactActivity:
        """What every contact point does over one period, a `contact_motion.ContactActivity`, as the run found it: (N_x,) arrays of a
        point, or (n, N_x) of all of them."""
        return contact_motion.activity(self, point)

    def dissipated(self, point: int, contact: int) -> float:
        """Energy a contact point takes from the structure per cycle [J]."""
        return float(self.contact_activity(point).dissipation[contact_motion.index(self, contact)])

    def elastic(self, point: int, n: int = 64, times: np.ndarray | None = None, sector: int | None = None) -> np.ndarray:
        """Elastic displacements of the full model, e = x_e0 + Phi a + Psi (x + x_p), equations (2) and (5).

        Parameters
        ----------
        point : int
        n : int
            Equal steps over one period ...
        times : (N,) array, optional
            ... or these times [s].
        sector : int, optional
            Of a cyclic structure; default 0.

        Returns
        -------
        (N, n_e) array, in the order of `elastic_dofs` of the reduced file.
        """
        return recovery.elastic(self, point, n, times, sector)

    def unknowns(self, point: int, dofs: list, n: int = 64, times: np.ndarray | None = None, sector: int | None = None) -> np.ndarray:
        """Some unknowns of the full model, (N, k), total values; dofs (k,) are their numbers there, other arguments as `elastic`."""
        return recovery.unknowns(self, point, dofs, n, times, sector)

    def displacement(self, point: int, nodes: list | None = None, n: int = 64, times: np.ndarray | None = None,
                     model: str | Path | None = None, sector: int | None = None, axes: str = "sector") -> np.ndarray:
        """Total displacement of nodes of the mesh, (N, k, 3) [m]; see `motion.nodal_displacement`."""
        from . import motion

        return motion.nodal_displacement(self, point, nodes, n, times, model, sector, axes)

    def full(self, point: int, n: int = 64, times: np.ndarray | None = None, sector: int | None = None) -> np.ndarray:
        """All unknowns of the full model in its order, (N, n_full), total values; arguments as `elastic`.

        Where joints have changed the coordinates these are sums and differences; `displacement` gives the motion of nodes.
        """
        return recovery.full(self, point, n, times, sector)

    def need_points(self) -> None:
        """Raises ValueError where no point has been computed yet."""
        if self._n == 0:
            raise ValueError(f"{self.path}: no point has been computed yet")

    def _refuse_no_peak(self, curve):
        self.need_points()
        said = " and ".join(f"{words}, {units.with_unit(f'{amplitude:.7g}', curve.unit)} at {self.place(value)}"
                            for value, amplitude, words in curve.ends())
        raise ValueError(f"{self.path}: {curve.name} has no peak between the ends of the sweep" + (f": it is {said}" if said else ""))

    def _of_dof(self, dof, points=None, name="points/coefficients"):
        """Coefficients (n, 2H+1) of an unknown, or of a node, at some points (a slice); or their slopes, by the name of the dataset."""
        points = slice(self._n) if points is None else points
        if curves.is_reduced(dof):
            return self._coefficients(points, self.dof_index(dof), name=name)
        if dof not in self._node_rows:
            from . import motion

            self._node_rows[dof] = motion.node_row(self, dof) if self.wave is None else motion.node_rows_by_harmonic(self, dof)
        row, width = self._node_rows[dof], 2 * self.harmonics + 1
        begin, end, _ = points.indices(self._n)
        block = max(1, BLOCK // (row.size * width))  # points in memory at a time
        parts = [along(row, self._coefficients(slice(i, min(i + block, end)), name=name)) for i in range(begin, end, block)]
        return np.concatenate([np.zeros((0, width)), *parts])

    def number(self, point: int) -> int:
        """A point counted from the beginning. Raises ValueError where there is none of that number."""
        self.need_points()
        return whole_number(point, "point", -self._n, self._n - 1) % self._n

    def coefficients_at(self, point: int, sector: int | None = None) -> np.ndarray:
        """Coefficients (N_a + 3 N_x, 2H+1) of one point; sector as for `hysteresis`."""
        return self._in_sector(self._coefficients(self.number(point)), sector)

    def _in_sector(self, coefficients, sector):
        if self.wave is None and sector is not None:
            raise ValueError(f"{self.path}: is not of a sector of a cyclic structure, so there is no sector {sector!r}")
        return coefficients if sector is None else self.wave.of_sector(coefficients, sector)

    def _coefficients(self, *which, name="points/coefficients"):
        width = 2 * self.harmonics + 1  # as it was when the file was opened
        return self._read(lambda file: np.asarray(file[name][which][..., :width], dtype=np.float64))

    def motion(self, point: int, n: int = 64, times: np.ndarray | None = None, sector: int | None = None) -> np.ndarray:
        """All unknowns in the order of `coefficients`, (N, N_a + 3 N_x), from the preload state; other arguments as `elastic`."""
        return fourier.course(self.coefficients_at(point, sector), self.omega[point], n, times)
