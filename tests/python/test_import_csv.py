"""Text blocks to model and reduced files, and what is said about wrong ones."""

import h5py
import numpy as np
import pytest

from dovetail import Model
from dovetail.importers import csv

KEE, KEC = np.array([[10.0, -10], [-10, 20]]), np.array([[0.0, 0, 0], [-10, 0, 0]])
KCC = np.array([[20.0, -10, 0], [-10, 20, -10], [0, -10, 20]])
STIFFNESS = """Name: Kee
10, -10
-10, 20

Name: Kcc
20 -10 0
-10\t20\t-10
0.0e0, -1e1, 20

"""
MASS = """
name : M_EE
1,0
0,1
Name: mcc
1,0,0
0,1,0
0,0,1
Name: Mec
0,0,0
0,0,0
"""
COUPLING = "Name: Kce\n0,-10\n0,0\n0,0\n\nName: Fe\n1\n2\n\nName: Pc\n0.1,0.2,0.3\n"
REDUCED = {"omega_a2": [[4.0, 9.0]], "Max": [[1, 2, 3], [4, 5, 6]], "Mxx": np.eye(3), "Kxx": KCC, "fa": [[1], [2]],
           "fx": [[1, 2, 3]], "Rx": [[4], [5], [6]]}


def files(folder, *texts):
    paths = [folder / f"{i}.csv" for i in range(len(texts))]
    for path, text in zip(paths, texts):
        path.write_text(text)
    return paths


def blocks(values):
    return "\n".join(f"Name: {name}\n" + "\n".join(",".join(map(str, row)) for row in rows) + "\n" for name, rows in values.items())


def test_full_model_from_several_files(tmp_path):
    said = csv.convert(files(tmp_path, STIFFNESS, MASS, COUPLING), tmp_path / "m.h5")
    assert said == "full model: 2 elastic degrees of freedom, 1 contact points; not given, taken as zero: Fc, Pe"
    model = Model.read(tmp_path / "m.h5")
    np.testing.assert_array_equal(model.K.toarray(), np.block([[KEE, KEC], [KEC.T, KCC]]))
    np.testing.assert_array_equal(model.M.toarray(), np.eye(5))
    np.testing.assert_array_equal(model.force, [1, 2, 0, 0, 0])
    np.testing.assert_array_equal(model.preload, [0, 0, 0.1, 0.2, 0.3])
    np.testing.assert_array_equal(model.contact_dofs, [[2, 3, 4]])


@pytest.mark.parametrize("squares", [[[4.0, 9.0]], [[4.0], [9.0]], [[4.0, 0], [0, 9.0]]])
def test_reduced_model(tmp_path, squares):
    recovery = {"Phi": np.arange(8).reshape(4, 2), "Psi": np.arange(12).reshape(4, 3), "xe0": [[1], [2], [3], [4]]}
    said = csv.convert(files(tmp_path, blocks({**REDUCED, "omega_a2": squares}), blocks(recovery)), tmp_path / "r.h5")
    assert said == "reduced model: 2 modes, 1 contact points; recovery from Phi, Psi, xe0"
    with h5py.File(tmp_path / "r.h5") as file:
        assert file.attrs["format"] == "dovetail-reduced" and file.attrs["version"] == 1
        for name, value in {"Kaa": [4, 9], "Max": REDUCED["Max"], "Mxx": np.eye(3), "Kxx": KCC, "Fa": [1, 2], "Fx": [1, 2, 3],
                            "R": [4, 5, 6], "recovery/Phi": recovery["Phi"], "recovery/Psi": recovery["Psi"],
                            "recovery/xe0": [1, 2, 3, 4]}.items():
            np.testing.assert_array_equal(file[name][()], value, err_msg=name)


@pytest.mark.parametrize("texts, message", [
    (["Name: omega_2\n1\n"], r"0.csv, line 1: unknown block name 'omega_2'; did you mean omega_a2\?"),
    (["Name: stiffness\n1\n"], "unknown block name 'stiffness'; known are Mee"),
    (["\n1,2\n"], "0.csv, line 2: wanted a heading such as 'Name: Kee' before the first numbers, found '1,2'"),
    (["Name: Kee\n1,2\n3\n"], "0.csv, line 3, block Kee: wanted 2 numbers as in the rows above, found 1"),
    (["Name: Kee\n1,2\n3,x4\n"], "0.csv, line 3, block Kee: wanted a number, found 'x4'"),
    (["Name: Kee\n1,NaN\n"], "0.csv, line 2, block Kee: wanted a finite number, found NaN"),
    (["Name: Kee\n\nName: Mee\n1\n"], "0.csv, line 1, block Kee: wanted numbers below the heading, found none"),
    (["\n"], "no block found; each must be headed"),
    ([STIFFNESS, "\n\nname: k_cc\n1\n"], "1.csv, line 3, block Kcc: given twice, first in .*0.csv, line 5, block Kcc"),
    ([STIFFNESS, MASS], "a full model needs the blocks .*; missing Kec, found Kcc, Kee, Mcc, Mec, Mee"),
    ([STIFFNESS, "Name: Rx\n1\n"], "blocks of a full model .*block Kee.* and of a reduced one .*1.csv, line 1, block Rx"),
    ([STIFFNESS, MASS, "Name: Kec\n1,2,3\n"], r"2.csv, line 1, block Kec: wanted 2 x 3 \(Kee has 2 rows, Kcc 3\), found 1 x 3"),
    ([STIFFNESS, MASS, COUPLING, "Name: Fc\n1,2\n"], r"3.csv, line 1, block Fc: wanted 3 numbers .*one per row of Kcc.*found 1 x 2"),
    ([STIFFNESS, MASS, COUPLING, "Name: Kec\n1,2,3\n4,5,6\n"], "block Kce: wanted the transpose of .*3.csv, line 1, block Kec"),
    ([STIFFNESS, MASS.replace("1,0,0\n0,1,0\n0,0,1", "1,0\n0,1"), COUPLING], "block Mcc: wanted 3 x 3 .*found 2 x 2"),
    ([STIFFNESS.replace("-10, 20\n\n", "\n\n"), MASS, COUPLING], "block Kee: wanted a square matrix, found 1 x 2"),
    ([STIFFNESS.replace("10, -10\n-10", "10, -9\n-10"), MASS, COUPLING], "K must be symmetric"),
    ([blocks({k: v for k, v in REDUCED.items() if k != "fx"})], "a reduced model needs .*; missing fx"),
    ([blocks({**REDUCED, "Max": [[1, 2], [3, 4]]})], r"block Max: wanted 2 x 3 \(omega_a2 has 2 entries, Kxx has 3 rows\), found 2 x 2"),
    ([blocks({**REDUCED, "omega_a2": [[4, -1]]})], "block omega_a2: wanted positive squared frequencies, found -1"),
    ([blocks({**REDUCED, "Kxx": np.eye(4)})], r"block Kxx: wanted 3 rows \(t1, t2, n\) per contact point, found 4"),
    ([blocks({**REDUCED, "Phi": np.ones((5, 3))})], r"block Phi: wanted 5 x 2 .*found 5 x 3"),
])
def test_errors_name_place_and_remedy(tmp_path, texts, message):
    with pytest.raises(ValueError, match=message):
        csv.convert(files(tmp_path, *texts), tmp_path / "out.h5")
    assert not (tmp_path / "out.h5").exists()
