"""Pictures of results, and of the mesh of a model: `python3 -m dovetail plot FILE.h5`."""

from pathlib import Path

from .letters import lend_letters
from .output_files import made
from .saved_picture import save_picture

MARGIN = 0.15  # around a picture in space [inch]
USED = {"response": ("at", "dof"), "waterfall": ("dof",), "history": ("at", "dof", "sector"), "hysteresis": ("at", "dof"),
        "map": ("at", "dof"), "pressure": (), "sensitivity": ("at",), "mode": ("dof", "harmonic"), "diameters": (), "campbell": (),
        "motion": ("at", "dof", "sector")}  # options, by kind of picture
SEVERAL = ("response", "waterfall", "mode")  # kinds of picture of more than one file


def plot(arguments):
    """Draw a picture of a results file, or of the mesh of a model file."""
    from .info import format_of

    path = Path(arguments.file)
    if arguments.further or arguments.labels or arguments.kind == "waterfall":
        return _several(path, arguments)
    if format_of(path) == "dovetail-model":
        if arguments.kind != "response":
            raise ValueError(f"{path}: is a model, of which the mesh is drawn; --kind {arguments.kind} is a picture of results")
        _refuse_unused(arguments, (), "of a mesh")
        figure, suffix = _picture_of_model(path, arguments.up), "_mesh.png"
    else:
        results = _results(path, arguments)
        if _is_film(arguments):
            return _film(results, arguments)
        figure, suffix = _picture_of_results(results, arguments)
    output = made(arguments.output or path.with_name(path.stem + suffix))
    save_picture(figure, output, **(cropped(figure) if suffix == "_mesh.png" else {}))
    print(output)


def cropped(figure):
    """Options of a picture in space without its empty margins: matplotlib would keep all of the square that the axes have."""
    import numpy as np
    from matplotlib.transforms import Bbox

    lend_letters(figure)
    figure.canvas.draw()
    rows, columns = np.nonzero(np.asarray(figure.canvas.buffer_rgba())[..., :3].min(axis=2) < 255)
    inked = Bbox([[columns.min(), figure.bbox.height - rows.max()], [columns.max(), figure.bbox.height - rows.min()]])
    return {"bbox_inches": inked.transformed(figure.dpi_scale_trans.inverted()).padded(MARGIN)}


def _several(path, arguments):
    """Draws the curves of several results into one picture."""
    from .plot_several import several, several_modes
    from .results import Results

    if arguments.kind not in SEVERAL or arguments.at is not None:
        raise ValueError(f"several files: wanted is --kind {', '.join(SEVERAL)}, without --at; found --kind {arguments.kind}"
                         + ("" if arguments.at is None else f" --at {arguments.at:g}"))
    if arguments.kind == "mode" and (arguments.dof or arguments.harmonic is not None):
        raise ValueError("several files with --kind mode: frequency and damping alone are drawn, without --dof and --harmonic")
    if arguments.dof and len(arguments.dof) > 1:
        raise ValueError(f"--dof {' '.join(arguments.dof)}: of several files one unknown is drawn")
    _refuse_unused(arguments, USED[arguments.kind], "of several files")
    runs = [Results(file, arguments.model) for file in (path, *arguments.further)]
    if arguments.kind == "mode":
        figure = several_modes(runs, arguments.labels, arguments.hz)
    else:
        figure = several(runs, arguments.labels, (arguments.dof or [None])[0], arguments.hz, arguments.kind == "waterfall")
    suffix = "_several.png" if arguments.kind == "response" else f"_several_{arguments.kind}.png"
    output = made(arguments.output or path.with_name(path.stem + suffix))
    save_picture(figure, output)
    print(output)


def _results(path, arguments):
    """The Results, which have the sector that is asked for."""
    from .results import Results
    from .shown import chosen_sectors

    results = Results(path, arguments.model)
    if arguments.sector is not None and arguments.kind not in ("motion", "history"):
        raise ValueError(f"--sector: is for motion and history; in a picture of kind {arguments.kind} all sectors are alike")
    _refuse_unused(arguments, USED[arguments.kind], f"of kind {arguments.kind}")
    chosen_sectors(results, arguments.sector)
    return results


def _refuse_unused(arguments, used, what):
    for option in ("at", "dof", "harmonic", "sector"):
        if getattr(arguments, option) is not None and option not in used:
            raise ValueError(f"--{option}: changes nothing in a picture {what}; leave it out")


def _is_film(arguments):
    if not arguments.output or Path(arguments.output).suffix.lower() != ".gif":
        return False
    if arguments.kind != "motion":
        raise ValueError(f"{arguments.output}: a film is of --kind motion; name another kind of picture FILE.png")
    return True


def _film(results, arguments):
    """Writes the motion over a period as a GIF."""
    from .motion_picture import motion_film

    point, output = _point_of_motion(results, arguments), made(arguments.output)
    motion_film(results, point, output, arguments.sector, arguments.up, arguments.hz)
    print(output)


def _point_of_motion(results, arguments):
    """The point that an export shows, too: by default the peak of the loaded node."""
    from .shown import chosen_point, default_dofs

    results.need_points()
    return chosen_point(results, arguments.at, arguments.hz, arguments.dof or default_dofs(results))


def _picture_of_model(path, up):
    from .hdf5_read import opened, words
    from .mesh_picture import mesh_picture
    from .motion import read_model_parts

    mesh, joint = read_model_parts(path)
    if mesh is None:
        raise ValueError(f"{path}: has no mesh to draw")
    with opened(path) as file:
        units = words(file, "units", "SI")
    return mesh_picture(mesh, joint, up, path.name, units)


def _picture_of_results(results, arguments):
    """The figure, and what its file name ends with."""
    from . import plot as pictures
    from .contact_map import contact_map
    from .shown import chosen_point, value_at

    if arguments.kind == "pressure":
        from .pressure_map import pressure_map

        return pressure_map(results, arguments.model), "_pressure.png"
    results.need_points()
    if arguments.kind == "diameters":
        from .diameters_picture import diameters

        return diameters(results, arguments.hz), "_diameters.png"
    if arguments.kind == "campbell":
        from .campbell_picture import campbell

        return campbell(results, arguments.hz), "_campbell.png"
    if arguments.kind == "sensitivity":
        from .sensitivity_map import sensitivity_map

        return sensitivity_map(results, _peak_near(results, arguments), arguments.model, arguments.hz), "_sensitivity.png"
    if arguments.kind == "mode":
        from .mode_picture import mode_picture

        return mode_picture(results, (arguments.dof or pictures.default_dofs(results))[0], arguments.harmonic, arguments.hz), "_mode.png"
    if arguments.kind == "response":
        at = None if arguments.at is None else value_at(results, arguments.at, arguments.hz)
        return pictures.response(results, arguments.dof, at, arguments.hz), ".png"
    if arguments.kind == "motion":
        from .motion_picture import motion_picture

        point = _point_of_motion(results, arguments)
        return motion_picture(results, point, arguments.sector, arguments.up, arguments.hz), "_motion.png"
    point = chosen_point(results, arguments.at, arguments.hz, arguments.dof)
    if arguments.kind == "history":
        return pictures.history(results, point, arguments.dof, arguments.hz, arguments.sector), "_history.png"
    if arguments.kind == "map":
        return contact_map(results, point, arguments.model, arguments.hz), "_map.png"
    return pictures.hysteresis(results, point, arguments.dof, arguments.hz), "_hysteresis.png"


def _peak_near(results, arguments):
    """The row of the sensitivities whose peak is nearest to --at, or none."""
    from .shown import value_at

    if arguments.at is None or not results.sensitivity:
        return None
    return int(abs(results.sensitivity.omega - value_at(results, arguments.at, arguments.hz)).argmin())
