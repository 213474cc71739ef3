"""Write one HDF5 file from many ranks: every rank holds a contiguous part of each dataset.

With an MPI build of h5py all ranks write at once; otherwise they take turns. Nothing is gathered in either case. The file
gets its name only when it is complete, so a killed write never leaves half a file under the final name.
"""

import os
from contextlib import suppress
from dataclasses import dataclass

import h5py
import numpy as np


@dataclass(frozen=True)
class Part:
    """This rank's share of dataset `name`: `values` go to [start, start + len(values)) of an array of `shape`."""

    name: str
    shape: tuple
    start: int
    values: np.ndarray


class Alone:
    """Stands in for an mpi4py communicator of one rank, so that serial use needs no MPI."""

    rank = 0
    size = 1

    def allgather(self, item):
        return [item]

    def barrier(self):
        pass


def default_comm():
    """All ranks when h5py is its MPI build (Debian loads that one under mpirun only), else this process alone."""
    if not h5py.get_config().mpi:
        return Alone()
    from mpi4py import MPI

    return MPI.COMM_WORLD


def agree(comm, message):
    """Raise ValueError on every rank when any rank brings a message (str) instead of None. Collective."""
    found = [m for m in comm.allgather(message) if m]
    if found:
        raise ValueError(found[0])


def write(path, parts, attributes, comm):
    """Write the file. Collective.

    Parameters
    ----------
    path : path-like
    parts : list of Part
        Same names and shapes in the same order on every rank.
    attributes : dict
        "" for the root, or the name of a group, to a dict of its attributes. Same on every rank.
    comm : mpi4py communicator or Alone
    """
    path = os.fspath(path)
    if os.path.isdir(path):
        raise ValueError(f"{path}: is a folder; name a file in it, such as {os.path.join(path, 'model.h5')}")
    unfinished = path + ".part"
    try:
        if comm.size > 1 and h5py.get_config().mpi:
            with h5py.File(unfinished, "w", driver="mpio", comm=comm) as file:
                _lay_out(file, parts, attributes)
                _fill(file, parts)
        else:
            for turn in range(comm.size):
                if turn == comm.rank:
                    with h5py.File(unfinished, "w" if turn == 0 else "r+") as file:
                        if turn == 0:
                            _lay_out(file, parts, attributes)
                        _fill(file, parts)
                comm.barrier()
    except BaseException:
        with suppress(OSError):
            os.unlink(unfinished)
        raise
    comm.barrier()
    if comm.rank == 0:
        os.replace(unfinished, path)
    comm.barrier()


def _lay_out(file, parts, attributes):
    for part in parts:
        file.create_dataset(part.name, shape=part.shape, dtype=part.values.dtype)
    for group, values in attributes.items():
        for key, value in values.items():
            file.require_group("/" + group).attrs[key] = value


def _fill(file, parts):
    for part in parts:
        if part.values.size:
            file[part.name][part.start:part.start + len(part.values)] = part.values
