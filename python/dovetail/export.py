"""Results for ParaView and tables: `python3 -m dovetail export RESULTS.h5`."""

import csv
import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .contact_period import contact_period, samples_of
from .export_frames import ContactFrames, MeshFrames, needed, write_instant, write_list
from .friction_energy import per_period
from .life import asked_life
from .motion import PlacesUnknown, find_joint
from .moving_mesh import PHASES, largest_at, moving_mesh
from .output_files import made, refuse_no_file
from .results import Results
from .shown import chosen_point, chosen_sectors, default_dofs
from .units import bracket
from .verify import looked_at

FRAMES, MOST_FRAMES = 24, 999
LIST = "export.json"  # what an export has written into its folder
CURVE = "curve.csv"
FIRST = "frequency [Hz]"  # column of the table
STATES = ("stick", "slip", "open")
OTHERS = (".vtu", ".pvd", ".vtk", ".png")  # endings of files that -o cannot name


def export(arguments):
    """The command."""
    results = Results(arguments.file, arguments.model)
    results.need_points()
    dofs = arguments.dof or default_dofs(results)
    if arguments.output and Path(arguments.output).suffix == ".csv":
        path = Path(arguments.output)
        if not _is_table(path):
            _refuse_other(path, arguments.replace)
        write_curve(results, made(path), dofs)
        print(path)
        return
    folder = Path(arguments.output) if arguments.output else results.path.with_name(f"{results.path.stem}_paraview")
    if arguments.output and folder.suffix.lower() in OTHERS:
        raise ValueError(f"{folder}: a table is written as FILE.csv, and all else into a folder, whose name does not end with "
                         f"{folder.suffix}")
    sectors = chosen_sectors(results, arguments.sector, arguments.wheel)
    steps = _steps(results, arguments, dofs[0])
    needed()
    cells = "solid" if arguments.solid else "surface" if arguments.surface or arguments.wheel else "as known"
    if arguments.wear is not None and arguments.wear < 0:
        raise ValueError(f"--wear: a volume per friction work is not negative, found {arguments.wear:g}")
    notes, parts = _parts(results, steps.points[0], sectors, steps.frames or PHASES, cells, arguments)
    files = {name: files_of(name, steps.count) for name in parts}
    begin(folder, [CURVE, *(f"{name}.pvd" for name in files), *(file for names in files.values() for file in names)], arguments.replace)
    write_curve(results, folder / CURVE, dofs)
    words = [f"  {folder / name}.pvd: {part.in_words()}; {steps.in_words()}" for name, part in parts.items()]
    for i, (point, share) in enumerate(steps):
        if point != steps.points[0]:
            parts = _parts(results, point, sectors, PHASES, cells, arguments)[1]
        at = share if share is not None else _largest(results, point, parts)
        for name in files:
            write_instant(folder / files[name][i], parts[name], at, {"point": point, "frequency": results.frequency[point]})
    for name in files:
        write_list(folder, name, steps.times(results), files[name])
    print("\n".join([steps.title(results), *words,
                     f"  {folder / CURVE}: the curve of {', '.join(dofs)}", *(f"  note: {note}" for note in notes)]))


@dataclass(frozen=True)
class Steps:
    """What is written one after the other: `frames` instants of the period of a point, or with 0 an instant of each of several."""

    points: list
    frames: int

    @property
    def count(self):
        return self.frames or len(self.points)

    def __iter__(self):
        """(point, share of the period or None) of each."""
        return iter([(self.points[0], i / self.frames) for i in range(self.frames)] or [(point, None) for point in self.points])

    def times(self, results):
        """[s] within a period; or numbers of the points, as a curve may turn back."""
        return np.arange(self.frames) / self.frames * 2 * np.pi / results.omega[self.points[0]] if self.frames else self.points

    def in_words(self):
        return f"{self.frames} instants of a period" if self.frames else f"{len(self.points)} points, at their largest motion"

    def title(self, results):
        if not self.frames:
            return f"{results.path}, {len(self.points)} of {len(results)} points"
        point = self.points[0]
        return f"{results.path}, point {point}: {results.place(results.along[point], 6)}, {results.frequency[point]:.6g} Hz"


def _steps(results, arguments, dof):
    """The Steps that are asked for."""
    for name, count in (("frames", arguments.frames), ("along", arguments.along)):
        if count is not None and not 1 <= count <= MOST_FRAMES:
            raise ValueError(f"--{name}: 1 to {MOST_FRAMES} are wanted, found {count}")
    if arguments.along is None:
        return Steps([number(results, arguments, dof)], FRAMES if arguments.frames is None else arguments.frames)
    others = [f"--{name}" for name in ("at", "point", "frames") if getattr(arguments, name) is not None]
    if others:
        raise ValueError(f"--along is of points all over the curve, {others[0]} of one; give one of the two")
    return Steps(looked_at(results, arguments.along), 0)


def _largest(results, point, parts):
    """Share of the period at which the mesh, or else what is watched, is farthest from its mean."""
    if "motion" in parts:
        return largest_at(parts["motion"].mesh) / (2 * np.pi)
    motion = results.time_history(point, results.watched, PHASES)[1]
    return int(np.argmax(np.abs(motion - motion.mean()))) / PHASES


def number(results, arguments, dof):
    """The point that is meant by --point or --at, or the peak of an unknown or a node."""
    if arguments.point is not None:
        if arguments.at is not None:
            raise ValueError("--point and --at both say which point is meant; give one of them")
        return results.number(arguments.point)
    return chosen_point(results, arguments.at, arguments.hz, [dof])


def _parts(results, point, sectors, frames, cells, arguments):
    """What is not there, in words, and what is: a dict of the name of a collection to MeshFrames or ContactFrames."""
    mesh, notes = _mesh(results, point, cells, sectors != [0])
    parts = {}
    if mesh is not None:
        found = None
        try:
            found = asked_life(results, point, arguments)
        except ValueError as error:
            if arguments.material or arguments.strengths or arguments.fatigue_strength is not None or arguments.tensile is not None:
                raise
            notes.append(f"no stress: {error}")
        parts["motion"] = MeshFrames(mesh, sectors, found)
    if results.contact_points:
        try:
            joint = find_joint(results)
            if arguments.wear is not None and not np.all(joint["area"] > 0):
                raise ValueError(f"{results.path}: the areas of its contact points are not known, so --wear gives no depth")
            if results.has_activity:
                period = contact_period(results, point, samples_of(frames, results.wave))
                parts["contact"] = ContactFrames.of(joint, period, mesh, sectors, results.frequency[point], arguments.wear)
            else:
                notes.append("no contact points: an older version wrote the run, without /points/contact; run the case again")
        except PlacesUnknown as error:
            notes.append(f"no contact points: {error}")
    if not parts:
        raise ValueError(f"{results.path}: there is nothing to show, -o FILE.csv writes the curve alone; {'; '.join(notes)}")
    return notes, parts


def _mesh(results, point, cells, needed):
    """The MovingMesh and what is to be said of it; `cells`: "solid", "surface", or "as known", all cells or else the outer faces."""
    try:
        return moving_mesh(results, point, surface=cells == "surface"), []
    except ValueError as error:
        why = error
    if cells == "as known":
        try:
            return moving_mesh(results, point, surface=True), ["outer faces alone: the run keeps no motion of all nodes inside"]
        except ValueError:
            pass
    if cells == "solid":
        raise ValueError(f"--solid: {why}")
    if needed or cells == "surface":
        raise why
    return None, [f"no motion of the mesh: {why}"]


def files_of(name, frames):
    return [f"{name}_{i:03d}.vtu" for i in range(frames)]


def begin(folder, planned, replace=False):
    """Makes the folder. What an earlier export has written there is taken away; other files of a name that is planned are refused."""
    old = []
    refuse_no_file(folder / LIST)
    if (folder / LIST).is_file():
        try:
            old = [name for name in json.loads((folder / LIST).read_text())["files"] if Path(name).name == name]
        except (ValueError, KeyError, TypeError):
            raise ValueError(f"{folder / LIST}: is no list of an export; delete it, or name another folder with -o") from None
    if folder.exists() and not folder.is_dir():
        raise ValueError(f"{folder}: is there already and is no folder; name another with -o")
    for name in planned:
        if name not in old:
            _refuse_other(folder / name, replace)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / LIST).write_text(json.dumps({"written by": "python3 -m dovetail export", "files": planned}, indent=1) + "\n")
    for name in set(old) - set(planned):
        (folder / name).unlink(missing_ok=True)


def _is_table(path):
    """Whether a file is a table that an export has written."""
    if not path.is_file():
        return False
    with open(path, "rb") as file:
        return file.read(len(FIRST) + 1) == f"{FIRST},".encode()


def _refuse_other(path, replace):
    refuse_no_file(path)
    if path.exists() and not (replace and path.is_file()):
        raise ValueError(f"{path}: is there already; name another with -o, or say --replace")


def write_curve(results, path, dofs):
    """The curve as a table: a row for every point of the branch."""
    unit = results.unit
    table = {FIRST: results.frequency, "omega" + bracket(unit.omega): results.omega}
    if results.parameter is not None:
        table[results.parameter_name + bracket(results.along_unit)] = results.parameter
    for curve in results.response(list(dofs)):
        table["amplitude of " + curve.name + bracket(curve.unit)] = curve.amplitude
    table |= {f"{state} points": results.points(state) for state in STATES}
    if results.has_activity:
        per = " per period and sector" if results.wave else " per period"
        table["friction energy" + per + bracket(unit.energy)] = per_period(results)
    if results.damping_ratio is not None:
        table["damping ratio"] = results.damping_ratio
    if results.stable is not None:
        table["stable"] = results.stable
    if results.error is not None:
        table["estimated error"] = results.error
    with open(path, "w", newline="") as file:
        out = csv.writer(file)
        out.writerow(table)
        out.writerows([f"{value:.10g}" for value in row] for row in zip(*table.values()))
