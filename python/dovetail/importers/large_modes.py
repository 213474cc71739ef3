"""Lowest modes of large matrices by SLEPc and MUMPS, where petsc4py and slepc4py are there."""

import numpy as np

from ..petsc_begin import petsc

PETSc = petsc()
from slepc4py import SLEPc  # noqa: E402


def lowest(K, M, count, shift):
    """Eigenvalues (count,) of SciPy matrices nearest above `shift`, which K - shift M is definite for, and vectors (n, count)."""
    comm = PETSc.COMM_SELF
    K, M = (PETSc.Mat().createAIJ(matrix.shape, comm=comm, csr=(matrix.indptr.astype(PETSc.IntType),
                                                                matrix.indices.astype(PETSc.IntType), matrix.data))
            for matrix in (K.tocsr(), M.tocsr()))
    problem = SLEPc.EPS().create(comm)
    problem.setOperators(K, M)
    problem.setProblemType(SLEPc.EPS.ProblemType.GHEP)
    problem.setTarget(shift)
    problem.setWhichEigenpairs(SLEPc.EPS.Which.TARGET_MAGNITUDE)
    problem.setDimensions(count)
    problem.getST().setType("sinvert")
    solver = problem.getST().getKSP()
    solver.setType("preonly")
    solver.getPC().setType("cholesky")
    solver.getPC().setFactorSolverType("mumps")
    problem.solve()
    if problem.getConverged() < count:
        raise ValueError(f"only {problem.getConverged()} of {count} modes of the stuck structure converged")
    vector, vectors, values = K.createVecRight(), np.empty((K.getSize()[0], count)), np.empty(count)
    for i in range(count):
        values[i] = problem.getEigenpair(i, vector).real
        vectors[:, i] = vector.getArray()
    return values, vectors
