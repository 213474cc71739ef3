"""The documents say what is so: links lead somewhere, commands do what the page shows, references name all there is."""

import argparse
import inspect
import json
import re
import tomllib

import pytest

import dovetail
from document_pages import anchors, alike, blocks, difference, is_followed, links, prose, run, runnable, same_line, tracked
from dovetail.__main__ import parser
from dovetail.importers import setup_file
from launch import ROOT

DOCS = ROOT / "docs"
PAGES = tracked("*.md")
USERS = [page for page in PAGES if page.parent == ROOT or ROOT / "inputs" in page.parents or page.parent.name == "template"
         or (DOCS in page.parents and page.parent.name != "notes")]
FOLLOWED = [page for page in PAGES if is_followed(page)]
RUN = [page for page in PAGES if runnable(page)]
SCHEMA = json.loads((ROOT / "python/dovetail/template/case-file.schema.json").read_text())  # test_schema.py: it is the program's


def keys_in(table, prefix=""):
    """Of the case file: name -> what the schema says of it."""
    for name, value in table["properties"].items():
        if value.get("type") == "object":
            yield from keys_in(value, f"{prefix}{name}.")
        else:
            yield prefix + name, value
        if value.get("type") == "array" and "properties" in value["items"]:
            yield from keys_in(value["items"], f"{prefix}{name}.")


KEYS = dict(keys_in(SCHEMA))
SETUP_KEYS = {"units", *(f"{kind}.{key}" for kind, keys in setup_file.KEYS.items() for key in keys)}


def name_of(page):
    return str(page.relative_to(ROOT))


def reference(name):
    return (DOCS / "reference" / f"{name}.md").read_text()


def listed(text):
    """Words in code at the beginning of list items, before the colon or the full stop."""
    items = re.findall(r"^ *- (.*?)(?::|\. |, default|, required|, only)", text, re.MULTILINE | re.DOTALL)
    return {word for item in items for word in re.findall(r"`([^`]+)`", item)}


# ------------------------------------------------------------------------------------------------------------- form
def test_readme_is_short():
    assert len((ROOT / "README.md").read_text().splitlines()) <= 120


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_lines_are_short(page):
    long = [number for number, line in enumerate(page.read_text().splitlines(), 1) if len(line) > 120]
    assert not long, f"{name_of(page)}: lines {long} are longer than 120 characters"


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_links_lead_somewhere(page):
    broken = []
    for target in links(page):
        path, _, anchor = target.partition("#")
        other = (page.parent / path).resolve() if path else page
        if not other.exists() or (anchor and anchor not in anchors(other)):
            broken.append(target)
    assert not broken


def test_every_page_is_found_from_the_index():
    pages = {page for page in PAGES if DOCS in page.parents and page.parent.name != "notes"} - {DOCS / "README.md"}
    linked = {(DOCS / target.partition("#")[0]).resolve() for target in links(DOCS / "README.md")}
    assert pages <= linked, sorted(map(name_of, pages - linked))


def test_no_page_needs_the_notes():
    """Measurements of a day are for those who want to know how things came about."""
    for page in USERS:
        if page.parent != DOCS / "developer":
            assert not [target for target in links(page) if "notes/" in target], name_of(page)


def test_no_page_of_users_tells_how_the_program_was_made_fast():
    """That is for notes. A damper may be tuned."""
    words = re.compile(r"\b(?:tuned (?!dampers?\b)|tuning|speed-?ups?|profil(?:ed|er|ing)|optimi[sz]ed|micro-?benchmarks?|cache miss|"
                       r"instruction counts?|we (?:measured|tried|found)|by trial)", re.IGNORECASE)
    pages = [page for page in USERS if page.parent not in (ROOT, DOCS / "developer")] + [ROOT / "README.md"]
    found = {name_of(page): words.findall(page.read_text()) for page in pages}
    assert len(found) > 50 and not {name: hits for name, hits in found.items() if hits}


def test_notes_are_dated():
    for page in (DOCS / "notes").glob("*.md"):
        assert page.name == "README.md" or re.match(r"\d{4}-\d\d-\d\d-", page.name), page.name


def test_documents_named_elsewhere_exist():
    """In code, messages, scripts, tests and examples."""
    for path in tracked("src", "python", "tests", "scripts", "inputs", "CMakeLists.txt", "cmake"):
        if path.suffix in (".png", ".h5", ".mat") or "corpus" in path.parts:
            continue
        for name in re.findall(r"\bdocs/[\w/.-]+\.(?:md|png)\b", path.read_text(errors="ignore")):
            assert "FORMAT" in name or (ROOT / name).exists(), f"{name_of(path)} names {name}"


def test_examples_begin_with_the_surroundings():
    """Else a newcomer's python3 knows no module dovetail."""
    for page in tracked("inputs/*/README.md"):
        indented = [line.strip() for line in page.read_text().splitlines() if line.startswith("    ")]
        assert indented[0].startswith("source scripts/environment"), name_of(page)
        assert not [line for line in indented if line.startswith(("python3 ", "dovetail "))], name_of(page)


def test_pages_of_importers_are_named_after_the_formats():
    from dovetail.importers import FORMATS

    for name in FORMATS:
        assert (DOCS / f"how-to/import-{'text' if name == 'csv' else name}.md").is_file()


# ------------------------------------------------------------------------------------------------- what is shown is so
@pytest.mark.parametrize("page", RUN, ids=name_of)
@pytest.mark.slow
def test_commands_do_what_the_page_shows(page, tmp_path):
    if not (ROOT / "build/dovetail").is_file():
        pytest.skip("no build/dovetail")
    complaints = run(page, tmp_path)
    if complaints is None:
        pytest.skip("a reader of foreign files is not installed")
    assert not complaints, "\n\n".join(complaints)


@pytest.mark.parametrize("page", FOLLOWED, ids=name_of)
def test_blocks_are_run_or_declared_as_text(page):
    for block in blocks(page):
        assert block.recomputes or block.kind in ("sh", "python", "toml", "text"), f"{name_of(page)}:{block.line}: ```{block.kind}"
        assert not (block.kind == "text" and block.output), f"{name_of(page)}:{block.line}: output of a block that is not run"
    indented = [line for line in page.read_text().splitlines() if re.match(r"    \S", line)]
    fenced = {line for block in blocks(page) for line in block.text.splitlines()}
    outputs = {line for block in blocks(page) for line in (block.output or "").splitlines()}
    assert not [line for line in indented if line not in fenced | outputs and line[4:] not in fenced], "an indented block is not run"


def test_settings_that_are_shown_exist():
    """Every ```toml block is TOML, and its keys are those of the case file or of the set-up file of an import."""
    def keys(table, prefix=""):
        for key, value in table.items():
            inner = value[0] if isinstance(value, list) and value and isinstance(value[0], dict) else value
            yield from keys(inner, f"{prefix}{key}.") if isinstance(inner, dict) else [f"{prefix}{key}"]

    for page in PAGES:
        for block in blocks(page):
            if block.kind == "toml" and page.parent.name != "notes":
                unknown = set(keys(tomllib.loads(block.text))) - set(KEYS) - SETUP_KEYS
                assert not unknown, f"{name_of(page)}:{block.line}: {sorted(unknown)}"


def test_output_is_compared_as_meant():
    shown = "a 1.5000 m\n...\n131 points, 300 Newton iterations, 0.2 s\n"
    assert not difference(shown, "a  1.5001 m\nx\ny\n129 points, 320 Newton iterations, 7 s\n")
    assert difference(shown, "a 1.51 m\n131 points, 300 Newton iterations, 0.2 s\n")
    assert difference(shown, "a 1.5 m\n99 points, 300 Newton iterations, 0.2 s\n")
    assert difference(shown, "a 1.5 m\nb\n") and difference("a\n", "a\nb\n") and difference("a\n", "")
    assert same_line("12 contact points", "12 contact points") and not same_line("12 contact points", "13 contact points")
    assert same_line("peak ... m at 3.0", "peak 1e-3 m at 3.0") and not same_line("peak 1", "peaks 1")
    assert alike("0.58057", "0.58099", "value") and not alike("0.58057", "0.58157", "value")


# ---------------------------------------------------------------------------------------------- references are complete
def test_case_file_reference_has_every_key_with_its_unit():
    shown = re.findall(r"^- `([a-z_.]+)`(?: \[([^\]]+)\])?,", reference("case-file"), re.MULTILINE)
    assert len(shown) == len(dict(shown)), "a key is there twice"
    assert dict(shown) == {key: value.get("x-unit", "") for key, value in KEYS.items()}
    assert len(KEYS) > 30 and KEYS["damping.stiffness"]["x-unit"] == "s"


def test_case_file_reference_has_defaults_and_words():
    """Of every key, as the program has them."""
    def words(value):
        if isinstance(value, list):
            return [word for item in value for word in words(item)]
        if isinstance(value, dict):
            return [*value.get("enum", []), *(word for item in value.values() for word in words(item))]
        return []

    text = reference("case-file")
    chosen = 0
    for key, value in KEYS.items():
        item = " ".join(re.search(rf"^- `{key}`.*?(?=^- `|^#|\n\n)", text, re.MULTILINE | re.DOTALL)[0].split())
        standard = value["x-default"]
        start = "required" if standard.startswith("required") else f"default {standard}".replace('"', "")
        said = re.sub(r"^- \w[\w.]*( \[[^\]]*\])?, ", "", item.replace("`", "").replace('"', ""))
        assert re.match(re.escape(start) + r"\b", said), f"{key}: {item[:80]}; the program: {start}"
        for word in words(value):
            chosen += 1
            assert f'`"{word}"`' in item, f"{key}: {word}"
    assert chosen > 30


def test_case_file_reference_has_the_keys_in_their_sections():
    for section in re.split(r"^## ", reference("case-file"), flags=re.MULTILINE)[1:]:
        heading = re.match(r"\[(\w+)\]", section)
        keys = re.findall(r"^- `([a-z_.]+)`", section, re.MULTILINE)
        assert all(key.split(".")[0] == heading[1] if heading else "." not in key for key in keys), section[:40]


def test_set_up_file_reference_has_every_key():
    text = reference("joints-file")
    for key in SETUP_KEYS:
        assert re.search(rf"`{key.split('.')[-1]}\b", text), key


def test_event_reference_has_every_event_count_and_end():
    source = (ROOT / "src/results/point_record.cpp").read_text()
    names = re.search(r"event_names\(\) \{(.*?)\n\}", source, re.DOTALL)[1]
    headings = r"^## (?:Events|Warnings|Counts|How a run ends)\n"
    events, warnings, counts, ends = re.split(headings, reference("events"), flags=re.MULTILINE)[1:]
    said = "".join(path.read_text() for path in (ROOT / "src/app").glob("*.cpp"))
    assert listed(warnings) == set(re.findall(r'push_back\(\s*\{"(\w+)"', said))
    assert listed(events) == set(re.findall(r'"(\w+)"', names))
    assert listed(counts) == set(re.findall(r'act\("(\w+)"', (ROOT / "src/results/counts.hpp").read_text()))
    summary = (ROOT / "src/results/summary.cpp").read_text()
    told = {word for item in re.findall(r"^- (.*?) \(", ends, re.MULTILINE) for word in re.findall(r"`(\w+)`", item)}
    assert told == set(re.findall(r'case BranchSummary::End::\w+:\s+return "(\w+)"', summary))


def test_command_line_reference_has_every_option():
    text = reference("command-line")
    usage = re.search(r"usage =(.*?);\n\n", (ROOT / "src/app/main.cpp").read_text(), re.DOTALL)[1]
    options = set(re.findall(r"--[a-z-]+", usage))
    commands = next(action for action in parser()._actions if isinstance(action, argparse._SubParsersAction)).choices
    for name, command in commands.items():
        assert f"`{name} " in text, name
        options |= {option for action in command._actions for option in action.option_strings if option.startswith("--")}
    assert not {option for option in options if not re.search(rf"{option}\b", text)}


def test_python_reference_has_every_public_name():
    text = reference("python")
    for name in set(dovetail.__all__) - {"__version__"}:
        section = re.search(rf"^## {name}\n(.*?)(?=^## )", text, re.MULTILINE | re.DOTALL)[1]
        thing = getattr(dovetail, name)
        public = [member for member, value in vars(thing).items() if not member.startswith("_") and
                  (inspect.isfunction(value) or isinstance(value, (property, classmethod)) or hasattr(value, "attrname"))]
        missing = [member for member in public if not re.search(rf"\b{member}\b", section)]
        assert not missing, f"{name}: {missing}"


def test_page_of_checks_has_a_section_on_every_warning():
    """dovetail check prints the link to it."""
    names = [path.name for path in (ROOT / "src/app").glob("*.cpp") if path.name != "judge_curve.cpp"]  # of a curve that is there
    said = "".join((ROOT / "src/app" / name).read_text() for name in names)
    headings = re.findall(r"^### (\w+)$", (DOCS / "how-to/check-a-case.md").read_text(), re.MULTILINE)
    assert len(headings) == len(set(headings)) and set(headings) == set(re.findall(r'push_back\(\s*\{"(\w+)"', said))


def test_messages_on_the_page_of_stops_are_the_programs():
    text = "".join(path.read_text() for path in tracked("src"))
    text = re.sub(r'//[^"\n]*$', "", text, flags=re.MULTILINE)  # comments
    text = re.sub(r'"\s*\n?\s*"', "", re.sub(r'" \+\s*\n?\s*"', "", text))
    headings = re.findall(r"^### `(.*)`$", (DOCS / "how-to/when-a-run-stops.md").read_text(), re.MULTILINE)
    assert len(headings) > 15
    assert not [heading for heading in headings if heading not in text]


def test_folders_include_those_above_them_in_the_table():
    table = (DOCS / "developer/architecture.md").read_text().split("## Folders")[1].split("Outside of")[0]
    order = re.findall(r"^\| `(\w+)` \|", table, re.MULTILINE)
    assert set(order) == {path.name for path in (ROOT / "src").iterdir() if path.is_dir()}
    for i, folder in enumerate(order):
        for path in tracked(f"src/{folder}"):
            for other in re.findall(r'^#include "(\w+)/', path.read_text(), re.MULTILINE):
                assert other not in order or order.index(other) <= i, f"{name_of(path)} includes {other}"


def test_every_strategy_has_its_line():
    """Names of recovery stand on the page that says when a run stops, and no others."""
    names = re.findall(r'{"(\w+)", (?:true|false)', (ROOT / "src/recovery/strategies.hpp").read_text())
    page = (DOCS / "how-to/when-a-run-stops.md").read_text().split("## Recovery")[1].split("```")[0]
    assert len(names) >= 4 and set(re.findall(r'`"(\w+)"`', page)) == set(names)


def test_glossary_terms_are_those_of_the_program():
    """What the glossary says the code calls a thing is in the code."""
    page = DOCS / "developer/glossary.md"
    code = "".join(path.read_text(errors="ignore") for path in tracked("src", "python/dovetail"))
    unknown = [word for word in re.findall(r"`(\w+)`", page.read_text()) if word not in code]
    assert not unknown and prose(page)
