"""Eigenfrequencies of a model with PETSc matrices, its contact points held, stuck or open. Needs slepc4py; collective."""

import numpy as np

from .petsc_begin import petsc

PETSc = petsc()
from slepc4py import SLEPc  # noqa: E402


def eigenfrequencies(K, M, count, below=0.0):
    """The lowest `count` eigenfrequencies [Hz] of K v = omega^2 M v, ascending.

    Parameters
    ----------
    K, M : petsc4py Mat, (n, n)
    count : int
    below : float
        K + (2 pi below)^2 M is factorised [Hz], so K may be singular if this is positive. Motions without stiffness come out as 0.
    """
    shift = -(2 * np.pi * below) ** 2
    problem = SLEPc.EPS().create(comm=K.getComm())
    problem.setOperators(K, M)
    problem.setProblemType(SLEPc.EPS.ProblemType.GHEP)
    problem.setWhichEigenpairs(SLEPc.EPS.Which.TARGET_MAGNITUDE)
    problem.setTarget(shift)
    problem.setDimensions(count)
    problem.setTolerances(tol=1e-12)
    transform = problem.getST()
    transform.setType("sinvert")
    transform.setShift(shift)
    solver = transform.getKSP()
    solver.setType("preonly")
    solver.getPC().setType("cholesky")
    solver.getPC().setFactorSolverType("mumps")
    solver.setErrorIfNotConverged(True)
    problem.solve()
    if problem.getConverged() < count:
        raise RuntimeError(f"only {problem.getConverged()} of {count} eigenfrequencies converged")
    squares = np.sort([problem.getEigenvalue(i).real for i in range(count)])
    squares[np.abs(squares) < 1e-6 * np.abs(shift)] = 0.0  # round-off of motions without stiffness
    problem.destroy()
    return np.sqrt(squares) / (2 * np.pi)


def characteristic(model, counts=(3, 3, 3), below=0.0):
    """Eigenfrequencies [Hz] of a model with contact points held, stuck and open: what friction moves between.

    Parameters
    ----------
    model : dovetail.Model
        With PETSc matrices and with contact stiffnesses.
    counts : (int, int, int)
        How many of each.
    below : float
        As in `eigenfrequencies`; positive where a body is held by its joint alone.

    Returns
    -------
    dict
        `held` (contact dofs zero), `stuck` (their stiffnesses act at every point), `open` (no contact): ascending arrays.
    """
    K, M, contact = model.K, model.M, model.contact_dofs
    begin, end = K.getOwnershipRange()

    def own(dofs):
        return (dofs >= begin) & (dofs < end)

    free = np.setdiff1d(np.arange(begin, end), contact[own(contact)]).astype(PETSc.IntType)
    free = PETSc.IS().createGeneral(free, comm=K.getComm())
    found = {"held": eigenfrequencies(K.createSubMatrix(free, free), M.createSubMatrix(free, free), counts[0])}
    diagonal = K.getDiagonal()
    stiffness = np.column_stack([model.contact["tangential_stiffness"], model.contact["normal_stiffness"]])
    diagonal.setValues(contact[own(contact)].astype(PETSc.IntType), stiffness[own(contact)], addv=PETSc.InsertMode.ADD_VALUES)
    diagonal.assemble()
    stuck = K.copy()
    stuck.setDiagonal(diagonal)
    return found | {"stuck": eigenfrequencies(stuck, M, counts[1]), "open": eigenfrequencies(K, M, counts[2], below)}
