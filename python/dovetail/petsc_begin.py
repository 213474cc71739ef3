"""Begins PETSc in a process of this package. Under mpirun as it stands; alone without what Open MPI starts for many."""

import os

RANKS = ("OMPI_COMM_WORLD_SIZE", "PMIX_RANK", "PMI_RANK")  # set by mpirun and srun
ALONE = {"OMPI_MCA_ess_singleton_isolated": "1",  # no daemon, which needs ssh on the path
         "OMPI_MCA_pml": "ob1",  # no look for networks: a fifth of a second
         "OMPI_MCA_orte_create_session_dirs": "0"}  # no folder, which the first such process to end would take from others


def petsc():
    """The module petsc4py.PETSc; raises ImportError where there is none. What it starts with is not passed on to child processes."""
    import petsc4py

    added = {} if any(name in os.environ for name in RANKS) else {name: ALONE[name] for name in ALONE if name not in os.environ}
    os.environ.update(added)
    try:
        petsc4py.init([])
        from petsc4py import PETSc
    finally:
        for name in added:
            del os.environ[name]
    return PETSc
