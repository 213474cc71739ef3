"""The published schema of the case file: made of the program's own table, it takes what is right and refuses what is wrong."""

import json
import re
import subprocess
import tomllib

import pytest

from document_pages import tracked
from launch import BINARY, ROOT, SECONDS

jsonschema = pytest.importorskip("jsonschema")

FILE = ROOT / "python/dovetail/template/case-file.schema.json"
CASES = [*tracked("inputs/*/*.toml"), ROOT / "python/dovetail/template/case.toml"]
RIGHT = (ROOT / "inputs/dof5/case.toml").read_text()


@pytest.fixture(scope="module")
def schema():
    return json.loads(FILE.read_text())


@pytest.fixture(scope="module")
def complaints(schema):
    jsonschema.Draft7Validator.check_schema(schema)
    validator = jsonschema.Draft7Validator(schema)
    return lambda text: list(validator.iter_errors(tomllib.loads(text)))


def keys_of(schema):
    for section, inside in schema["properties"].items():
        for key, value in inside.get("properties", {"": inside}).items():
            yield f"{section}.{key}".rstrip("."), value


def test_published_schema_is_the_programs():
    said = subprocess.run([BINARY, "--schema"], capture_output=True, text=True, timeout=SECONDS, check=True).stdout
    assert FILE.read_text() == said, f"build/dovetail --schema >{FILE.relative_to(ROOT)}"
    assert len(said) < 100_000


def test_case_files_name_it():
    for path in CASES:
        word, place = path.read_text().splitlines()[0].split()
        assert word == "#:schema" and (path.parent / place).resolve() == FILE, path


def test_every_key_has_help_unit_and_default_for_the_editor(schema):
    keys = dict(keys_of(schema))
    assert len(keys) > 60
    for name, value in keys.items():
        assert len(value["description"]) > 10, name
        assert "default" in value["description"] or "required" in value["description"], name
    assert keys["damping.stiffness"]["default"] == 0 and "[s]" in keys["damping.stiffness"]["description"]
    assert keys["harmonic_balance.solver"]["enum"] == ["modal", "assembled"]


def test_defaults_are_valid(schema):
    for name, value in keys_of(schema):
        if "default" in value:
            jsonschema.Draft7Validator(value).validate(value["default"])


@pytest.mark.parametrize("file", CASES, ids=lambda file: str(file.relative_to(ROOT)))
def test_shipped_case_files_are_valid(file, complaints):
    assert not complaints(file.read_text())


def test_template_with_every_key_is_valid(complaints):
    """Of keys that exclude each other a schema knows model and reduced alone."""
    text = re.sub(r"^# (\w+ = )", r"\1", CASES[-1].read_text(), flags=re.MULTILINE)
    assert not complaints(re.sub(r"^reduced = .*$", "", text, flags=re.MULTILINE))
    assert complaints(text)


@pytest.mark.parametrize("old, new", [
    ("modes = 2", 'modes = "two"'), ("modes = 2", "modes = -1"), ("modes = 2", "modes = 2.5"), ("modes = 2", "mods = 2"),
    ("[newton]", "[newtn]"), ("stiffness = 0.05", "stiffness = -0.05"), ("harmonics = 10", "harmonics = 0"),
    ("samples = 64", 'samples = "many"'), ("samples = 64", "samples = 2"), ('kind = "none"', 'kind = "never"'),
    ("omega = [0.9, 1.3]", "omega = [0.9]"), ("omega = [0.9, 1.3]", "omega = [0.9, 1.3, 1.4]"), ("omega = [0.9, 1.3]", "omega = 0.9"),
    ("omega = [0.9, 1.3]", "omega = [0, 1.3]"), ("adaptive = false", 'adaptive = "false"'), ("step_tolerance = 1e-5", "step_tolerance = 1"),
    ("friction = [1.0, 1.0]", "friction = [1.0, -1.0]"), ("friction = [1.0, 1.0]", "friction = [[1.0, 1.0, 1.0]]"),
    ("normal_stiffness = 1.0 ", "normal_stiffness = 0 "), ("[contact]", '[contact]\nlaw = "coulom"'),
    ("[damping]", "[damping]\nratios = [[0, 0.1]]"), ("[damping]", "[damping]\nratios = [[1, 2]]"),
    ('model = "model.h5"', ""), ('model = "model.h5"', 'model = "model.h5"\nreduced = "reduced.h5"'),
    ("fourier = [0, 0, 1]", 'load = [{pattern = "force"}]'), ('directory = "out"', 'motion = "some"'),
    ('title = "five-degree-of-freedom example"', "title = 5"),
])
def test_wrong_case_files_are_refused(old, new, complaints):
    assert old in RIGHT and complaints(RIGHT.replace(old, new))


def test_what_the_parser_asks_for_is_in_the_table(schema):
    """A key of one and not of the other."""
    source = "".join(path.read_text() for path in (ROOT / "src/case").glob("*.cpp"))
    keys = dict(keys_of(schema)) | {f"excitation.load.{key}": 0 for key in ("pattern", "fourier")}
    asked = set(re.findall(r'document\["([\w.]+)"\]', source))
    assert len(asked) > 40 and asked <= set(keys)
