"""The notebook of the tutorial runs from its first cell to its last, and its outputs are those that it shows."""

import re

import pytest

from document_pages import same_line
from launch import ROOT, SECONDS

nbformat = pytest.importorskip("nbformat")
nbclient = pytest.importorskip("nbclient")

PAGE = ROOT / "docs/tutorial/friction.ipynb"


def texts(cell):
    """What a cell has printed or returned, in lines; pictures by their kind alone."""
    lines = []
    for output in cell.get("outputs", []):
        data = output.get("data", {})
        text = "a picture" if "image/png" in data else output.get("text") or data["text/plain"]
        lines += [line for line in text.splitlines() if line.strip()]
    return lines


@pytest.mark.slow
def test_every_cell_shows_what_it_gives(monkeypatch):
    monkeypatch.setenv("PYTHONPATH", str(ROOT / "python"))
    shown = nbformat.read(PAGE, 4)
    run = nbformat.read(PAGE, 4)
    nbclient.NotebookClient(run, timeout=SECONDS, resources={"metadata": {"path": str(PAGE.parent)}}).execute()
    pictures = 0
    for before, after in zip(shown.cells, run.cells):
        assert len(texts(before)) == len(texts(after)), before.source
        pictures += texts(after).count("a picture")
        for wanted, found in zip(texts(before), texts(after)):
            assert same_line(wanted, found), (before.source, wanted, found)
    assert pictures == 3


def test_its_links_lead_somewhere():
    text = "\n".join(cell.source for cell in nbformat.read(PAGE, 4).cells if cell.cell_type == "markdown")
    places = re.findall(r"\]\(([^)#]+)", text)
    assert len(places) > 2 and all((PAGE.parent / place).exists() for place in places)
