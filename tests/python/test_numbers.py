"""Numbers in texts and tables: those that a comment recomputes are compared, and a wrong one is found."""

import re
import subprocess

import pytest

from document_pages import Block, claims, recomputing, tracked
from launch import ROOT, SECONDS

PAGES = tracked("*.md")


def wrong(text, printed, within=0.0):
    """Complaints about a text whose comment prints this."""
    block = Block("numbers", "", 1, "", "", text, within)
    return [finding.why for finding in claims(ROOT / "page.md", block, printed) if finding.why]


@pytest.mark.parametrize("text, printed", [
    ("The peak lies\nat 1038.6 rad/s.", "The peak lies at 1038.617 rad/s"),
    ("24 639 dofs", "24 639 dofs"),
    ("an error of 6e-4:", "an error of 0.000627"),
    ("| 1 | 2.0e-3 | 5 s |\n| 2 | 4.1e-3 | 7 s |\n", "| 2 | 0.00408 | ... |\n| 1 | 0.00199 | ... |"),
    ("from 3 to 5, then from 7 to 9", "from 7.1 to 9.2\nfrom 3 to 5"),
])
def test_right_numbers_are_passed(text, printed):
    assert not wrong(text, printed)


@pytest.mark.parametrize("text, printed", [
    ("at 1038.6 rad/s", "at 1038.7 rad/s"),
    ("12 points", "13 points"),
    ("12 points", "12 dofs"),  # no such words
    ("12 points", "2 points"),  # nor a part of a number
    ("1.8 %", "8 %"),
    ("at 1.5 Hz", "at nan Hz"),
    ("| 1 | 2.0 |\n", "| 1 | 2.0 |\n| 1 | 2.0 |"),  # every place answers for one line
    ("-2.1 %", "2.1 %"),
    ("| 1 | 2.0 |\n| 3 | 4.0 |\n", "| ... | 3 | 4.0 |"),  # a row is a row
    ("12 points", ""),
])
def test_wrong_numbers_are_found(text, printed):
    assert len(wrong(text, printed)) == 1


def test_tolerances_are_what_the_comment_says():
    assert wrong("1.500 m", "1.505 m") == ["1.500 is 1.505"]
    assert not wrong("1.500 m", "1.505 m", 1e-2) and wrong("1.500 m", "1.505 m", 1e-3)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_every_comment_is_understood(page):
    """None is left out by a slip of the pen, and each has its text right below."""
    found = recomputing(page)
    assert len(found) == len(re.findall(r"^ {0,3}<!--\s*number", page.read_text(), re.MULTILINE))
    assert all(block.output.strip() and 0 <= block.within < 0.5 for block in found)


def test_the_command_tells_what_is_wrong(tmp_path):
    page = tmp_path / "page.md"
    page.write_text("""<!-- numbers python:
print("two and two are", 2 + 2)
-->
Two and two are 5, or
two and two are 5.

<!-- numbers:
echo three and three are 6
-->
Known: three and three are 6.

<!-- numbers slow: echo 7 years -->
This takes 9 years.

<!-- numbers: cat no_such_file -->
And 8.
""")
    done = subprocess.run([ROOT / "scripts/numbers", page], capture_output=True, text=True, timeout=SECONDS)
    assert done.returncode == 1, done.stderr
    lines = done.stdout.splitlines()
    assert lines[0].endswith('page.md:5: 5 is 4: "two and two are 5", recomputed "two and two are 4"')
    assert lines[1].endswith('page.md:10: ok: "three and three are 6", recomputed "three and three are 6"')
    assert "ended with 1" in lines[2] and "page.md:16" in lines[2]
    assert lines[-1] == "numbers: 1 agree, 2 places differ; 1 comments are slow and left out"
