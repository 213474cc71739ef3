from pathlib import Path

from spack_repo.builtin.build_systems.cmake import CMakePackage

from spack.package import *


class Dovetail(CMakePackage):
    """Periodic response of jointed structures with friction and contact, by harmonic balance."""

    git = f"file://{Path(__file__).resolve().parents[6]}"  # the clone that this file lies in

    license("BSD-3-Clause")
    version("main", branch="main")
    generator("ninja")

    depends_on("c", type="build")
    depends_on("cxx", type="build")
    depends_on("cmake@3.20:", type="build")
    depends_on("pkgconfig", type="build")
    depends_on("googletest", type="build")

    depends_on("mpi")
    depends_on("lapack")
    depends_on("scalapack")
    depends_on("petsc@3.18,3.22 +mpi+mumps+double~complex")
    depends_on("slepc@3.18,3.22")
    depends_on("mumps+mpi+metis+double")  # without METIS or SCOTCH factors take more room and time
    depends_on("metis@5:")
    depends_on("hdf5+mpi")
    depends_on("fftw@3:")
    depends_on("toml11@3.7:4")

    with default_args(type=("build", "run")):
        depends_on("python@3.11:")
        depends_on("py-numpy")
        depends_on("py-scipy")
        depends_on("py-matplotlib")
        depends_on("py-h5py+mpi")
        depends_on("py-mpi4py")
        depends_on("py-petsc4py")
        depends_on("py-slepc4py")

    def cmake_args(self):
        return [self.define("DOVETAIL_MUMPS", "petsc"), self.define("Python3_EXECUTABLE", self.spec["python"].command.path)]
