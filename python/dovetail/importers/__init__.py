"""Readers of foreign formats.

A reader of meshes with matrices offers read(files) -> Structure, with `notes` about what was taken; joints come from a set-up file.
A reader of files that know their contact points offers convert(files, output) -> summary text.
"""

import importlib
import os
from contextlib import contextmanager

import h5py

FORMATS = {
    "calculix": "job.inp with job.sti, job.mas, job.dof beside it",
    "abaqus": "job.inp with job_STIF1.mtx, job_MASS1.mtx beside it",
    "ansys": "an archive (CDWRITE) with a full file or Harwell-Boeing matrices",
    "nastran": "bulk data with DMIG punch or OP4 matrices",
    "matrices": "K=FILE M=FILE contact_dofs=FILE index_base=1: Matrix Market, MATLAB, PETSc",
    "csv": "text blocks headed by 'Name: Kee' and so on",
}


@contextmanager
def naming(files):
    """Puts the files in front of a ValueError that names none of them."""
    try:
        yield
    except ValueError as error:
        paths = [path for path in (str(word).rpartition("=")[2] for word in files) if os.path.exists(path)]
        if any(path in str(error) for path in paths):
            raise
        raise ValueError(f"{', '.join(map(str, files))}: {error}") from None


def _refuse_foreign(output):
    """A file that is there is replaced if it is a model or a reduced file, or what a killed import left of one."""
    from ..info import format_of

    def what(path, unfinished):
        if os.path.islink(path):
            return "a symbolic link"
        if not os.path.exists(path) or unfinished and (h5py.is_hdf5(path) or not os.path.getsize(path)):
            return None
        try:
            return None if format_of(path) in ("dovetail-model", "dovetail-reduced") else "a results file"
        except ValueError:
            return "no file that dovetail wrote, or damaged"

    for path in (str(output), f"{output}.part"):
        if found := what(path, path.endswith(".part")):
            raise ValueError(f"{path}: is {found}, and the import would replace it; move it away, or give another name behind -o")


def convert(kind, files, output, setup=None):
    """Files of another program to a model file, or with csv a reduced file; with a set-up file, case.toml beside it, if there is none.

    Parameters
    ----------
    kind : str
        A key of FORMATS.
    files : list of str
    output : str
        File to write.
    setup : str, optional
        Set-up file (setup_file.py) with supports, loads and joints; for formats with a mesh, which need one.

    Returns
    -------
    str
        What was taken and written, in words.

    Raises
    ------
    ValueError
        `notes` of it, where there are any: what had been read until then, in words.
    """
    _refuse_foreign(output)
    module = importlib.import_module(f".{kind}", __name__)
    if hasattr(module, "convert"):
        if setup is not None:
            raise ValueError(f"{setup}: {kind} files hold their contact points themselves; leave --setup out")
        with naming(files):
            return module.convert(files, output)
    if setup is None:
        raise ValueError(f"{kind} files hold no joints; say with --setup joints.toml which surfaces touch")
    from . import case_file
    from .setup_file import apply

    with naming(files):
        structure = module.read(files)
    try:
        model = apply(structure, setup)
    except ValueError as error:
        error.notes = [*structure.notes, *_lines(error.notes)]
        raise
    model.write(output)
    summary = f"full model: {model.n} degrees of freedom, {model.contact_points} contact points"
    return "\n  ".join([summary, *structure.notes, *_lines(model.notes), case_file.write(model, output)])


def _lines(notes):
    return "\n".join(notes).split("\n") if notes else []
