"""The smallest valid input of every importer: one tetrahedron, held by a contact at three nodes and loaded at the fourth.

An input of the fuzzers stands in the place of one file of a job, the others being as they should.
"""

import importlib.util
import shutil
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np
import scipy.io
import scipy.sparse as sp

from dovetail.importers import convert

NODES = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
SETUP = """units = "mm"
[[force]]
set = "{tip}"
vector = [0, 1, 0.5]
[[joint]]
ground = "{foot}"
normal_stiffness = 1e3
tangential_stiffness = [1e3, 500]
friction = 0.3
gap = 0.1
normal = [0, 0, -1]
"""
CLAMPS = """[[clamp]]
set = "TIP"
directions = "x"
[[preload]]
set = "FOOT"
vector = [0, 0, 1]
[[joint]]
ground = "FOOT"
at = "FOOT"
normal = [0, 0, -1]
t1 = [1, 0, 0]
normal_stiffness = 1e3
"""
BOLTED = """[[spring]]
set = "FOOT"
stiffness = [1.0, 2.0, 0]
[[preload]]
step = 1
[[bolt]]
between = ["TIP", "FOOT"]
axis = [0, 0, -1]
force = 0.5
then = "lock"
stiffness = 2.0
tighten_with_friction = true
[[joint]]
ground = "BOTTOM"
normal_stiffness = 1e3
tangential_stiffness = 5e2
friction = 0.3
"""
CARDS = """*SURFACE, NAME=LEFT, TYPE=NODE
2,
*SURFACE, NAME=RIGHT, TYPE=NODE
3,
*TIE, CYCLIC SYMMETRY, NAME=SIDES
RIGHT, LEFT
*CYCLIC SYMMETRY MODEL, N=4, TIE=SIDES
0., 0., 0., 0., 0., 1.
"""  # the tetrahedron as a quarter of a wheel about z
SECTOR = """[cyclic]
sectors = 4
left = "LEFT"
right = ["RIGHT"]
axis = [0, 0, 1]
origin = [0, 0, 2.5]
tolerance = 1e-6
[[joint]]
ground = "TIP"
normal = [0, 0, 1]
"""
BLOCKS = """Name: Kee
10, -10
-10, 20

name: K_ec
0 0 0
-10 0 0

Name: Kcc
20 -10 0
-10 20 -10
0 -10 20
Name: Mee
1 0
0 1
Name: Mec
0 0 0
0 0 0
Name: Mcc
1 0 0
0 1 0
0 0 1
Name: Fe
1
1
"""
REDUCED = """Name: omega_a2
1, 4
Name: Max
.1 .1 .1
.1 .1 .1
Name: Mxx
1 0 0
0 1 0
0 0 1
Name: Kxx
2 -1 0
-1 2 -1
0 -1 2
Name: fa
1 0.5
Name: fx
1 1 1
Name: Rx
1 1 1
Name: xe0
0 0
"""
MESH = """*HEADING
*NODE, NSET=ALL
1, 0., 0., 0.
2, 1., 0., 0.
3, 0., 1., 0.
4, 0., 0., 1.
*ELEMENT, TYPE=C3D4, ELSET=BODY
1, 1, 2, 3, 4
*NSET, NSET=FOOT, GENERATE
1, 3, 1
*NSET, NSET=TIP
4,
*ELSET, ELSET=ONE
BODY,
*SURFACE, NAME=BOTTOM, TYPE=ELEMENT
BODY, S1
*SURFACE, NAME=NODES, TYPE=NODE
FOOT,
*BOUNDARY
TIP, 4, 6
"""
CALCULIX = MESH + "*STEP\n*FREQUENCY, SOLVER=MATRIXSTORAGE\n1\n*CLOAD\nTIP, 1, 2.5\n*END STEP\n"
LOADED = MESH.replace("TIP, 4, 6", "TIP, 1, 1") + """*EQUATION
2
4, 2, 2.0, 3, 2, -1.0
*STEP
*STATIC
*CLOAD
TIP, 3, -1.0
*DLOAD, OP=NEW
BODY, P1, 0.5
*END STEP
*STEP
*FREQUENCY, SOLVER=MATRIXSTORAGE
1
*CLOAD, LOAD CASE=2
TIP, 2, 1.5
*DLOAD
1, P3, 1.0
BODY, GRAV, 9.81, 0., 0., -1.
*DSLOAD
BOTTOM, P, 0.5
*END STEP
"""
ABAQUS = MESH + "*STEP\n*MATRIX GENERATE, STIFFNESS, MASS, LOAD\n*MATRIX OUTPUT, STIFFNESS, MASS, LOAD, FORMAT=MATRIX INPUT\n*END STEP\n"
ARCHIVE = """/COM,ANSYS RELEASE 2019 R2
/PREP7
ET,        1,285
NBLOCK,6,SOLID,         4,         4
(3i9,6e21.13e3)
        1        0        0
        2        0        0 1.0000000000000E+000
        3        0        0 0.0000000000000E+000 1.0000000000000E+000
        4        0        0 0.0000000000000E+000 0.0000000000000E+000 1.0000000000000E+000
N,R5.3,LOC,       -1,
EBLOCK,19,SOLID,         1,         1
(19i10)
""" + "".join(f"{k:10d}" for k in (1, 1, 1, 1, 0, 0, 0, 0, 4, 0, 1, 1, 2, 3, 4)) + """
        -1
CMBLOCK,FOOT    ,NODE,       2  ! users node component definition
(8i10)
         1        -3
CMBLOCK,TIP     ,NODE,       1  ! users node component definition
(8i10)
         4
FINISH
"""
DECK = """SOL 103
CEND
SET 5 = 4
BEGIN BULK
GRID,1,,0.,0.,0.
GRID,2,,1.,0.,0.
GRID,3,,0.,1.,0.
GRID,4,,0.,0.,1.
CTETRA,1,1,1,2,3,4
SPC1,3,456,1,THRU,4
SET1,8,1,2,3
SPOINT,9
ENDDATA
"""


def tetrahedron():
    """(12, 12) stiffness for a modulus of 1 and Poisson's ratio 0.25, and lumped mass."""
    slopes = np.linalg.inv(np.c_[np.ones(4), NODES])[1:]  # of the four shape functions
    B = np.zeros((6, 12))
    for a in range(4):
        x, y, z = slopes[:, a]
        B[:, 3 * a:3 * a + 3] = [[x, 0, 0], [0, y, 0], [0, 0, z], [y, x, 0], [0, z, y], [z, 0, x]]
    D = 0.4 * np.diag([2, 2, 2, 1, 1, 1.0])
    D[:3, :3] += 0.4
    return B.T @ D @ B / 6, np.eye(12) / 24


K, M = tetrahedron()
DOFS = [(node, direction) for node in (1, 2, 3, 4) for direction in (1, 2, 3)]


@dataclass
class Job:
    """Files by name, and what converts them: read(folder) with the words of the command line."""

    kind: str
    files: dict
    words: tuple
    setup: str = None

    def run(self, folder):
        named = [word.replace("@", f"{folder}/") for word in self.words]
        return convert(self.kind, named, str(folder / "model.h5"), setup=self.setup and str(folder / self.setup))


def triangle(matrix, line):
    return "".join(line(i, j, matrix[i, j]) for j in range(12) for i in range(j + 1)).encode()


def _calculix(cards=""):
    def entry(i, j, value):
        return f"{i + 1} {j + 1} {value:.12e}\n"
    dofs = "".join(f"{node}.{direction}\n" for node, direction in DOFS)
    deck = CALCULIX.replace("*BOUNDARY", cards + "*BOUNDARY", 1)
    return {"job.inp": deck.encode(), "job.sti": triangle(K, entry), "job.mas": triangle(M, entry), "job.dof": dofs.encode()}


def _loaded():
    """Node 4 is held along x, and follows node 3 along y."""
    T = np.zeros((12, 10))
    kept = [k for k, dof in enumerate(DOFS) if dof not in ((4, 1), (4, 2))]
    T[kept, range(10)] = 1
    T[DOFS.index((4, 2)), kept.index(DOFS.index((3, 2)))] = 0.5

    def text(matrix):
        small = T.T @ matrix @ T
        return "".join(f"{i + 1} {j + 1} {small[i, j]:.12e}\n" for j in range(10) for i in range(j + 1)).encode()
    dofs = "".join(f"{DOFS[k][0]}.{DOFS[k][1]}\n" for k in kept)
    return {"job.inp": LOADED.encode(), "job.sti": text(K), "job.mas": text(M), "job.dof": dofs.encode()}


def _abaqus():
    def entry(i, j, value):
        (node, direction), (other, along) = DOFS[i], DOFS[j]
        return f"{node},{direction}, {other},{along},  {value:.12e}\n"
    return {"job.inp": ABAQUS.encode(), "job_STIF1.mtx": triangle(K, entry), "job_MASS1.mtx": triangle(M, entry),
            "job_LOAD1.mtx": b"*CLOAD, REAL\n4, 1, 2.5\n*CLOAD, IMAGINARY\n4, 1, 0.\n"}


def _harwell_boeing(matrix, right=None):
    lower = sp.tril(matrix).tocsc()
    lower.sort_indices()
    columns, entries = 12, lower.nnz
    lines = ["Stiffness".ljust(72) + "K", "".join(f"{k:14d}" for k in (0, columns + 1, entries, entries, 12 if right is not None else 0)),
             "RSA".ljust(14) + "".join(f"{k:14d}" for k in (12, columns, entries, 0)), "(1I14)  (1I14)  (1D25.15)  (1D25.15)"]
    lines += ["F  "] if right is not None else []
    lines += [f"{k + 1:14d}" for k in (*lower.indptr, *lower.indices)]
    lines += [f"{value:25.15E}".replace("E", "D") for value in (*lower.data, *(() if right is None else right))]
    return ("\n".join(lines) + "\n").encode()


def _ansys():
    mapping = "    Matrix Eqn.       Node    Dof\n" + "".join(f"{row:12d}{node:12d}    U{'XYZ'[direction - 1]}\n"
                                                             for row, (node, direction) in enumerate(DOFS, 1))
    return {"job.cdb": ARCHIVE.encode(), "K.matrix": _harwell_boeing(K, np.arange(12.0)), "M.matrix": _harwell_boeing(M),
            "K.mapping": mapping.encode()}


def _dmig():
    lines = []
    for name, matrix in (("KAAX", K), ("MAAX", M)):
        lines.append(f"DMIG,{name},0,6,2,0,,,")
        for j, (node, direction) in enumerate(DOFS):
            for i in range(j, 12):
                if matrix[i, j]:
                    lines.append(f"DMIG,{name},{node},{direction},,{DOFS[i][0]},{DOFS[i][1]},{matrix[i, j]:.6E}".replace("E", "D"))
    return {"job.bdf": DECK.encode(), "job.pch": ("\n".join(lines) + "\n").encode()}


def _op4(folder):
    from cpylog import SimpleLogger
    from pyNastran.op2.result_objects.matrix import Matrix
    from pyNastran.op4.op4 import OP4

    matrices = {key: Matrix(key, 6, data=sp.coo_matrix(matrix)) for key, matrix in (("KAA", K), ("MAA", M))}
    OP4(log=SimpleLogger(level="error")).write_op4(str(folder / "job.op4"), matrices, name_order=list(matrices), is_binary=False)
    rows = "".join(f"{node} {direction}\n" for node, direction in DOFS).encode()
    written = {"op4": (folder / "job.op4").read_bytes(), "binary_op4": _binary("KAA", K) + _binary("MAA", M)}
    return {name: {"job.bdf": DECK.encode(), "job.op4": content, "job.rows": rows} for name, content in written.items()}


def _binary(name, matrix):
    """A dense matrix as binary OP4: records with their length before and behind."""
    def record(*parts):
        content = b"".join(parts)
        return np.int32(len(content)).tobytes() + content + np.int32(len(content)).tobytes()
    head = record(np.array([12, 12, 6, 2], "i4").tobytes(), name.ljust(8).encode())
    columns = [record(np.array([j + 1, 1, 24], "i4").tobytes(), matrix[:, j].tobytes()) for j in range(12)]
    return b"".join([head, *columns, record(np.array([13, 1, 2], "i4").tobytes(), np.float64(1).tobytes())])


def _matrix_files(folder):
    """The matrices and vectors in every format: Matrix Market, MATLAB 4, 5 and 7.3, PETSc."""
    contact = np.array([[1, 2, 3], [4, 5, 6]])
    values = {"K": sp.csc_matrix(K), "M": sp.csc_matrix(M), "contact_dofs": contact, "index_base": 1.0, "force": np.ones(12)}
    scipy.io.mmwrite(folder / "K.mtx", sp.coo_matrix(K), symmetry="symmetric")
    scipy.io.mmwrite(folder / "M.mtx", M)
    for name, version in (("v4.mat", "4"), ("v5.mat", "5")):
        scipy.io.savemat(folder / name, values, format=version, do_compression=False)
    with h5py.File(folder / "v73.mat", "w", libver="latest") as file:
        for name in ("K", "M"):
            group = file.create_group(name)
            group.attrs["MATLAB_sparse"] = np.uint64(12)
            group["data"] = values[name].data
            group["ir"], group["jc"] = values[name].indices.astype("u8"), values[name].indptr.astype("u8")
        file["contact_dofs"], file["index_base"], file["force"] = contact.T.astype(float), [[1.0]], np.ones((1, 12))
    text = {"contact.txt": b"# t1, t2, n\n1, 2, 3\n4, 5, 6\n", "force.txt": b"1 " * 12 + b"\n", "gap.txt": b"0.1\n0.2\n"}
    files = {name: (folder / name).read_bytes() for name in ("K.mtx", "M.mtx", "v4.mat", "v5.mat", "v73.mat")}
    n, full = np.array(12, ">i4"), sp.csr_matrix(K)
    petsc = np.array([1211216, 12, 12, full.nnz, *np.diff(full.indptr), *full.indices], ">i4").tobytes() + full.data.astype(">f8").tobytes()
    return files | text | {"K.petsc": petsc, "f.petsc": np.array([1211214, n], ">i4").tobytes() + np.ones(12, ">f8").tobytes()}


def jobs(folder):
    """Every Job that can run here, by name. `folder` is for files on the way."""
    mesh, tet = SETUP.format(tip="TIP", foot="BOTTOM").encode(), SETUP.format(tip="TIP", foot="FOOT").encode()
    found = {"csv": Job("csv", {"blocks.txt": BLOCKS.encode()}, ("@blocks.txt",)),
             "csv_reduced": Job("csv", {"blocks.txt": REDUCED.encode()}, ("@blocks.txt",)),
             "calculix": Job("calculix", _calculix() | {"joints.toml": mesh}, ("@job.inp",), "joints.toml"),
             "setup": Job("calculix", _calculix() | {"joints.toml": CLAMPS.encode()}, ("@job.inp",), "joints.toml"),
             "bolted": Job("calculix", _loaded() | {"joints.toml": BOLTED.encode()}, ("@job.inp",), "joints.toml"),
             "cyclic": Job("calculix", _calculix(CARDS) | {"joints.toml": SECTOR.encode()}, ("@job.inp",), "joints.toml"),
             "abaqus": Job("abaqus", _abaqus() | {"joints.toml": tet}, ("@job.inp",), "joints.toml")}
    files = _matrix_files(folder)
    plain = ("contact_dofs=@contact.txt", "index_base=1", "force=@force.txt", "gap=@gap.txt")

    def matrices(*words):
        return Job("matrices", {name: files[name] for name in files if any(word.endswith("@" + name) for word in words)}, words)
    found["market"] = matrices("K=@K.mtx", "M=@M.mtx", *plain)
    found["petsc"] = matrices("K=@K.petsc", "M=@M.mtx", "preload=@f.petsc", *plain[:2])
    found |= {name: matrices(f"@{name}.mat") for name in ("v4", "v5", "v73")}
    if importlib.util.find_spec("ansys"):
        words = ("@job.cdb", "K=@K.matrix", "M=@M.matrix", "@K.mapping", "load=preload")
        found["ansys"] = Job("ansys", _ansys() | {"joints.toml": tet}, words, "joints.toml")
        examples = Path(importlib.util.find_spec("ansys.mapdl.reader").origin).parent / "examples"
        full = {"file.full": (examples / "file.full").read_bytes(), "HexBeam.cdb": (examples / "HexBeam.cdb").read_bytes()}
        beam = SETUP.format(tip="NCOMP2", foot="NODE_SELECTION").replace("normal = [0, 0, -1]", "at = [[1, 0.25, 3]]").encode()
        found["ansys_full"] = Job("ansys", full | {"joints.toml": beam}, ("@file.full", "@HexBeam.cdb"), "joints.toml")
    if importlib.util.find_spec("pyNastran"):
        nastran = SETUP.format(tip="SET 5", foot="SET1 8").encode()
        found["dmig"] = Job("nastran", _dmig() | {"joints.toml": nastran}, ("@job.bdf", "@job.pch"), "joints.toml")
        for name, kept in _op4(folder).items():
            found[name] = Job("nastran", kept | {"joints.toml": nastran}, ("@job.bdf", "@job.op4", "@job.rows"), "joints.toml")
    return found


def lay_out(job, folder):
    """The files of a job in a folder that holds nothing else."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    for name, content in job.files.items():
        (folder / name).write_bytes(content)
