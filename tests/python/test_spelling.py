"""Words of documents, comments and messages are English, by hunspell, or stand in words.txt: the field's terms, programs, names."""

import io
import re
import shutil
import subprocess
import tokenize
from functools import cache
from pathlib import Path

import pytest

from document_pages import prose, tracked
from launch import ROOT

TERMS = set((Path(__file__).parent / "words.txt").read_text().split())
CODE = re.compile(r"`[^`]*`|https?://\S+|\]\([^)]*\)|<[^>\n]*>|\S*[\w)][_./\\=:^*|]+[\w(]\S*|\S*\\\w\S*|--?\w[\w-]*")
WORD = re.compile(r"(?<![\w.{%$@&#-])[A-Za-z]{3,}(?![\w}%=(\[])")
CPP = re.compile(r"""(?P<text>"(?:\\.|[^"\\\n])*")|'(?:\\.|[^'\\\n])'|//(?P<line>[^\n]*)|/\*(?P<block>.*?)\*/""", re.DOTALL)
SENTENCE = re.compile(r"\b(?:a|and|are|by|for|has|in|is|it|no|not|of|or|the|to|with)\b")  # else a literal is code
NAME = re.compile(r"\w*[a-z][A-Z]\w*")  # of classes and functions

needs_hunspell = pytest.mark.skipif(not shutil.which("hunspell"), reason="no hunspell: scripts/setup installs it where it is to be had")


def words(text):
    """Those of plain text. Words in capitals are names."""
    return {word for word in WORD.findall(CODE.sub(" ", text)) if not word.isupper()}


def of_page(path):
    return words(prose(path))


def of_cpp(path):
    found = list(CPP.finditer(path.read_text()))
    told = [match["text"][1:-1] for match in found if match["text"] and SENTENCE.search(match["text"])]
    return words(NAME.sub(" ", "\n".join([*told, *(match["line"] or match["block"] or "" for match in found)])))


def of_python(path):
    """Of tests without literals: these are wrong on purpose."""
    said = []
    for token in tokenize.generate_tokens(io.StringIO(path.read_text()).readline):
        is_message = ROOT / "tests" not in path.parents and SENTENCE.search(token.string)
        if token.type == tokenize.COMMENT or token.type == tokenize.STRING and (token.string.startswith('"""') or is_message):
            said.append(re.sub(r"\{[^}]*\}", " ", token.string))
    return words(NAME.sub(" ", "\n".join(said)))


def of_script(path):
    return words("\n".join(re.findall(r"(?:^|\s)#\s(.*)", path.read_text(), re.MULTILINE))) if path.suffix != ".py" else set()


KINDS = {"documents": (["*.md"], of_page), "C++": (["src/*.cpp", "src/*.hpp", "tests/*.cpp", "tests/*.hpp"], of_cpp),
         "Python": (["*.py"], of_python), "scripts": (["scripts", "inputs/*.toml", "python/*.toml", "*CMakeLists.txt"], of_script)}


@cache
def written(kind):
    patterns, words_of = KINDS[kind]
    return {path: words_of(path) for path in tracked(*patterns)}


def unknown(found):
    """Of a set of words, those that hunspell does not know."""
    done = subprocess.run(["hunspell", "-d", "en_GB", "-l"], input="\n".join(sorted(found)), capture_output=True, text=True, check=True)
    return set(done.stdout.split())


@needs_hunspell
@pytest.mark.parametrize("kind", KINDS)
def test_words_are_spelt_right(kind):
    found = {path: said - TERMS for path, said in written(kind).items()}
    wrong = unknown(set().union(*found.values()))
    assert not {str(path.relative_to(ROOT)): sorted(said & wrong) for path, said in found.items() if said & wrong}


def test_the_list_holds_only_what_is_written():
    assert TERMS == {word for kind in KINDS for said in written(kind).values() for word in said & TERMS} and len(TERMS) < 400


@needs_hunspell
def test_wrong_words_are_found(tmp_path):
    (tmp_path / "a.md").write_text("A teh in text, `not in cdoe`.\n")
    (tmp_path / "a.cpp").write_text('int cuont;  // the nubmer\nthrow Error("a wrogn key");\n')
    (tmp_path / "a.py").write_text('"""Docs of a moduel."""\ncuont = 1  # the nubmer\nraise ValueError(f"no {fiel}: a wrogn key")\n')
    assert unknown(of_page(tmp_path / "a.md")) == {"teh"}
    assert unknown(of_cpp(tmp_path / "a.cpp")) == {"nubmer", "wrogn"}
    assert unknown(of_python(tmp_path / "a.py")) == {"moduel", "nubmer", "wrogn"}
