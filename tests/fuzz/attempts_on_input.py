"""What an adversary does to the files that a run reads: case file, model, results and state, files of other programs."""

import json
import random
import shutil
import subprocess
import tomllib
from pathlib import Path

import h5py
import hdf5_edits
import importer_jobs
import jsonschema
import mutate
import numpy as np
from attempt import CASE, Attempt, case_text, rewrite

VALUES = ["nan", "inf", "-inf", "-1", "0", "1e308", "1e-320", "-1e-300", "0.5", "99999999999999999999", "9223372036854775807", "1e999",
          "true", '""', '"\u00e9\u4e2d\U0001f529"', '"a\\u0000b"', '"\\u001b[2J"', "'../../etc/passwd'", '"' + "x" * 100_000 + '"', "[]",
          "[[]]", "[nan, nan]", "[1, -1]", "[1, 'two']", "[1e308, 1e308, 1e308]", "{}", "{ a = 1 }", "1979-05-27T07:32:00Z", "[{}, {}]",
          "0x7fffffff", "1_000_000"]
NO_NUMBERS = ("nan", "inf", "1e999")
TEXTS = {  # whole case files; of those that are no TOML, or say a thing twice, nothing can be right
    "empty": b"",
    "a null byte": b"\0",
    "nothing but null bytes": bytes(5000),
    "another encoding": case_text().encode("utf-16"),
    "a mark of the encoding first": b"\xef\xbb\xbf" + case_text().encode(),
    "no UTF-8": case_text().encode() + b"title = '\xff\xfe'\n",
    "an overlong sequence": case_text().encode() + b"title = '\xc0\xaf'\n",
    "a control character": case_text().encode() + b"title = '\x1b[2J'\n",
    "half a surrogate": case_text().encode() + b'title = "\\ud800"\n',
    "ends of lines of Windows": case_text().replace("\n", "\r\n").encode(),
    "returns alone": case_text().replace("\n", "\r").encode(),
    "a key twice": (case_text() + "damping.stiffness = 0.1\n").encode(),
    "a table twice": (case_text() + "[newton]\n[newton]\n").encode(),
    "a table and a key": (case_text() + "[model]\na = 1\n").encode(),
    "a key of a value": (case_text() + "model.a = 1\n").encode(),
    "deep lists": f"{case_text()}x = {'[' * 100_000}{']' * 100_000}\n".encode(),
    "deep lists without end": (case_text() + "x = " + "[" * 100_000).encode(),
    "deep tables": (case_text() + "[" + ".".join(["a"] * 50_000) + "]\n").encode(),
    "deep keys": (case_text() + ".".join(["a"] * 50_000) + " = 1\n").encode(),
    "deep tables in line": f"{case_text()}x = {'{a=' * 20_000}1{'}' * 20_000}\n".encode(),
    "an unknown key": (case_text() + "wish = 1\n").encode(),
    "a key near another": (case_text() + "dampingg.stiffness = 1\n").encode(),
    "a key of a million letters": (case_text() + "k" * 10**6 + " = 1\n").encode(),
    "an empty key": (case_text() + '"" = 1\n').encode(),
    "a quoted key with an end of line": (case_text() + '"a\\nb" = 1\n').encode(),
    "a hundred thousand keys": (case_text() + "".join(f"k{i} = 1\n" for i in range(10**5))).encode(),
    "no end of a text": (case_text() + 'title = "a').encode(),
    "no end of a list": (case_text() + "continuation.at = [1, 2").encode(),
    "XML": b"<?xml version='1.0'?><case/>",
    "JSON": json.dumps({"model": "model.h5"}).encode(),
    "a directive": (case_text() + "%include '/etc/passwd'\n").encode(),
    "a program": b"#!/bin/sh\nrm -rf *\n",
}
TAKEN = {"ends of lines of Windows", "a mark of the encoding first", "a control character"}  # these may be understood
CASES = {  # keys that do not go together, or ask for what there is not
    "no such model": {"model": '"absent.h5"'},
    "a folder as the model": {"model": '"."'},
    "the case as the model": {"model": '"case.toml"'},
    "the device of zeros as the model": {"model": '"/dev/zero"'},
    "results as the model": {"model": '"out/results.h5"'},
    "a state as the model": {"model": '"out/state.h5"'},
    "a model as reduced": {"model": None, "reduced": '"model.h5"', "reduction__modes": None},
    "results as reduced": {"model": None, "reduced": '"out/results.h5"', "reduction__modes": None},
    "both kinds of model": {"reduced": '"out/reduced.h5"'},
    "neither": {"model": None},
    "more modes than dofs": {"reduction__modes": "2000000000"},
    "no load": {"excitation__fourier": "[0]"},
    "a load without a pattern": {"excitation__fourier": None, "excitation__load": '[{ pattern = "absent", fourier = [0, 1] }]'},
    "a load of two kinds": {"excitation__load": '[{ pattern = "lift", fourier = [0, 1] }]'},
    "too few samples": {"harmonic_balance__samples": "3"},
    "a sweep of no width": {"continuation__omega": "[1.0, 1.0]"},
    "an engine order without a sector": {"excitation__engine_order": "4"},
    "a path without its parameter": {"path__range": "[1, 2]"},
    "a mode and a path": {"mode__number": "1", "mode__amplitude": "[1e-3, 1]", "path__parameter": '"friction"'},
    "a mode that is not there": {"continuation__omega": None, "mode__number": "1000", "mode__amplitude": "[1e-3, 1]"},
    "motion of a set that is not there": {"output__motion": '["absent"]'},
    "a start that is not there": {"continuation__start": '"absent.h5"'},
    "a model as the start": {"continuation__start": '"model.h5"'},
    "a watched dof that is not there": {"continuation__watch": '"x7.t1"'},
    "laws of more points than there are": {"contact__law": '["coulomb", "coulomb"]'},
    "memory of nothing": {"reduction__memory": "1e-300"},
    "points wanted outside": {"continuation__at": "[5.0]"},
    "points wanted twice": {"continuation__at": "[1.0, 1.0]"},
    "a path over a joint that is not there": {"continuation__omega": None, "path__parameter": '"friction"', "path__joint": '"absent"',
                                              "path__range": "[0.1, 0.2]", "path__omega": "1.0"},
}
MAY_RUN = {"a sweep of no width", "memory of nothing", "too few samples", "points wanted twice", "no load", "points wanted outside"}


def keys_of(schema, prefix=""):
    for name, entry in schema["properties"].items():
        if "properties" in entry:
            yield from keys_of(entry, f"{prefix}{name}.")
        else:
            yield prefix + name


def case_keys(program, dice, count):
    """Keys of the schema with values drawn. What the schema refuses, and numbers that are none, must be refused."""
    schema = json.loads(subprocess.run([program, "--schema"], capture_output=True, check=True).stdout)
    validator, keys = jsonschema.Draft7Validator(schema), sorted(keys_of(schema))
    for i in range(count):
        key, value = keys[i % len(keys)], dice.choice(VALUES)
        changed = {key.replace(".", "__"): value}
        valid = validator.is_valid(tomllib.loads(case_text(**changed).replace("\\u0000", "0").replace("1e999", "1e308")))
        refuse = not valid or any(word in value for word in NO_NUMBERS) and value[0] not in "\"'"
        yield Attempt("case file: a value", f"{key} = {value[:40]!r}", rewrite(**changed), refuse=refuse)


def case_texts():
    for name, text in TEXTS.items():
        yield Attempt("case file: its text", name, lambda folder, text=text: (folder / "case.toml").write_bytes(text),
                      refuse=name not in TAKEN)
    for name, changed in CASES.items():
        yield Attempt("case file: keys that clash", name, rewrite(**changed), refuse=name not in MAY_RUN)


def damaged_case(dice, count):
    for i in range(count):
        text = mutate.mutate(case_text().encode(), dice)
        yield Attempt("case file: bytes changed", str(i), lambda folder, text=text: (folder / "case.toml").write_bytes(text))


def edited(name, change):
    """A change of an HDF5 file of the folder."""
    def edit(folder):
        with h5py.File(folder / name, "r+") as file:
            hdf5_edits.apply(file, [change])
    return edit


def put(name, index, value):
    """One entry of a dataset replaced."""
    def edit(folder):
        with h5py.File(folder / name[0], "r+") as file:
            values = file[name[1]][()]
            values[index] = value
            file[name[1]][...] = values
    return edit


def bytes_changed(name, change):
    """A change of the bytes of a file of the folder."""
    return lambda folder: (folder / name).write_bytes(change((folder / name).read_bytes()))


def model_numbers():
    """Matrices and indices that make no structure."""
    def sparse(matrix, change):
        def edit(folder):
            K = {"K": hdf5_edits.K, "M": np.eye(5)}[matrix].copy()
            change(K)
            with h5py.File(folder / "model.h5", "r+") as file:
                del file[matrix]
                columns = hdf5_edits.sp.csc_matrix(K)
                file.create_group(matrix).attrs["MATLAB_sparse"] = np.uint64(5)
                for key, values in (("data", columns.data), ("ir", columns.indices.astype("u8")), ("jc", columns.indptr.astype("u8"))):
                    file[matrix][key] = values
        return edit

    def at(i, j, value):
        return lambda K: K.__setitem__((i, j), value)
    for matrix in "KM":
        for name, change in {"asymmetric": at(0, 1, 3.0), "with a NaN": at(1, 1, np.nan), "with an infinity": at(0, 0, np.inf),
                             "negative": lambda K: K.__imul__(-1), "nothing": lambda K: K.fill(0), "huge": lambda K: K.__imul__(1e308),
                             "one entry 1e300": at(0, 0, 1e300), "one entry of an elastic dof negative": at(0, 0, -50.0)}.items():
            yield Attempt("model: matrices", f"{matrix} {name}", sparse(matrix, change), refuse="huge" not in name and "1e300" not in name)
    places = {"contact/dofs": [-1, 5, 2**40, 3], "mesh/dof_node": [-1, 99], "mesh/dof_direction": [7], "mesh/sets/tip": [-5, 400],
              "mesh/changed/column": [77], "mesh/changed/begin": [9, -2], "K/ir": [5, 2**63], "K/jc": [0, 2**40], "M/ir": [9]}
    for name, values in places.items():
        for value in values:
            refuse = not name.startswith("mesh/")  # a mesh names unknowns, and changes no answer
            yield Attempt("model: indices", f"{name}[0 or last] = {value}", put(("model.h5", name),
                                                                                -1 if "jc" in name or "begin" in name else 0, value),
                          refuse=refuse)
    contacts = {"contact/normal_stiffness": [np.nan, 0.0, -1.0, np.inf], "contact/friction": [np.nan, -0.3, np.inf],
                "contact/gap": [np.nan, np.inf],
                "contact/tangential_stiffness": [np.nan, -1.0, 0.0], "force": [np.nan, np.inf], "preload": [np.nan, -np.inf],
                "forces/lift": [np.nan]}
    for name, values in contacts.items():
        for value in values:
            yield Attempt("model: values", f"{name} = {value}", put(("model.h5", name), 0, value), refuse=name != "forces/lift")


def model_files(dice, edits, cuts):
    for label, change in dice.sample(hdf5_edits.all_edits("model"), edits):
        yield Attempt("model: HDF5 edited", label, edited("model.h5", change))
    yield from cut_off("model: bytes", "model.h5", ("run", "case.toml"), dice, cuts, refuse=False)


def cut_off(kind, name, words, dice, count, refuse):
    for i in range(count):
        part = dice.random()
        yield Attempt(kind, f"{name} cut off at {part:.3f}", bytes_changed(name, lambda data, part=part: data[:int(part * len(data))]),
                      words, refuse=refuse)
        seed = dice.random()
        yield Attempt(kind, f"{name} changed, {seed:.6f}",
                      bytes_changed(name, lambda data, seed=seed: mutate.mutate(data, random.Random(seed))), words)


def restart_files(start, dice, edits, cuts):
    """Results, state, reduced file and stuck modes of the earlier run, and --restart."""
    words, more = ("run", "case.toml", "--restart"), rewrite(continuation__max_points="8")
    for name in ("results.h5", "state.h5", "reduced.h5"):
        with h5py.File(start / "out" / name) as file:
            known = list(hdf5_edits.edits_of(file))
        for label, change in dice.sample(known, edits):
            edit = edited(f"out/{name}", change)
            yield Attempt("restart: HDF5 edited", f"{name} {label}", lambda folder, edit=edit: (more(folder), edit(folder)), words)
        for attempt in cut_off("restart: bytes", f"out/{name}", words, dice, cuts, refuse=False):
            edit = attempt.change
            attempt.change = lambda folder, edit=edit: (more(folder), edit(folder))
            yield attempt
    names = ("results.h5", "state.h5", "reduced.h5", "summary.json", "../model.h5", "../case.toml")
    for to in names[:3]:
        for source in names:
            if source != to:
                yield Attempt("restart: files mixed up", f"{source} as {to}",
                              lambda folder, to=to, source=source: (more(folder), shutil.copyfile(folder / "out" / source,
                                                                                                  folder / "out" / to)), words)
    for key, value in CASE.items():
        other = {"reduction.modes": "1", "damping.stiffness": "0.1", "harmonic_balance.harmonics": "3", "continuation.omega": "[1.3, 0.9]",
                 "excitation.fourier": "[0, 0, 2]", "harmonic_balance.samples": "64"}.get(key)
        if other:
            yield Attempt("restart: of another case", f"{key} = {other}", rewrite(**{key.replace(".", "__"): other,
                                                                                     "continuation__max_points": "8"}), words)
    for version in (0, 2, 10**9, -1):
        for name in ("results.h5", "state.h5", "reduced.h5"):
            def later(folder, name=name, version=version):
                more(folder)
                with h5py.File(folder / "out" / name, "r+") as file:
                    file.attrs["version"] = version
            # a reduced file of another version is made anew
            yield Attempt("restart: of another version", f"{name} of version {version}", later, words, refuse=name != "reduced.h5")


def imports(folder, dice, each):
    """Files of other programs, changed or cut off, through the command line."""
    Path(folder).mkdir()
    for name, job in sorted(importer_jobs.jobs(Path(folder)).items()):
        words = ("import", job.kind, *(word.replace("@", "") for word in job.words), "-o", "made.h5", *(("--setup",
                                                                                                         job.setup) if job.setup else ()))
        for i in range(each):
            place, cut = dice.choice(sorted(job.files)), dice.random()
            content = job.files[place]
            content = content[:int(cut * len(content))] if i % 2 == 0 else mutate.mutate(content, dice)

            def lay_out(folder, job=job, place=place, content=content):
                for file, good in job.files.items():
                    (folder / file).write_bytes(content if file == place else good)
            yield Attempt("import", f"{name}: {place} {'cut off' if i % 2 == 0 else 'changed'} {i}", lay_out, words, package=True)


def readers(dice, each):
    """The package's commands on results with something wrong in them."""
    edits = hdf5_edits.all_edits("results")
    for command in (("info",), ("verify",), ("plot", "-o", "made.png"), ("export", "-o", "made.csv"), ("peaks",), ("stress",)):
        words = (command[0], "out/results.h5", *command[1:])
        for label, change in dice.sample(edits, each):
            yield Attempt("package: results edited", f"{command[0]}: {label}", edited("out/results.h5", change), words, package=True)
        yield from (attempt for attempt in package_cut(words, dice))


def package_cut(words, dice):
    for attempt in cut_off("package: results' bytes", "out/results.h5", words, dice, 1, refuse=False):
        attempt.package, attempt.name = True, f"{words[0]}: {attempt.name}"
        yield attempt
