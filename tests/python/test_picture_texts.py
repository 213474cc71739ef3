"""Pictures at the size people see them: no text over another, none cut off, whatever kind of picture it is."""

import os
import subprocess
import sys

import numpy as np
import pytest
from matplotlib import font_manager, pyplot
from matplotlib.text import Text
from PIL import Image

import brick
from dovetail import letters, plot_command
from dovetail.__main__ import main
from dovetail.mesh_picture import mesh_picture
from dovetail.plot_labels import place_labels
from dovetail.saved_picture import save_picture
from launch import BINARY, ROOT, SURROUNDINGS

KINDS = ("response", "history", "hysteresis", "map", "pressure", "motion", "waterfall")
BESIDE = 1.0  # by how much boxes of texts may meet [pixels]


def texts(figure):
    """(text, box) of all that is written, without ticks beyond the ends of an axis and those of hidden axes."""
    figure.canvas.draw()
    renderer, hidden = figure.canvas.get_renderer(), set()
    for axes in figure.axes:
        for axis in (axes.xaxis, axes.yaxis):
            shown = set(axis._update_ticks()) if axes.axison and axes.name != "3d" else set()
            hidden |= {label for tick in axis.majorTicks + axis.minorTicks if tick not in shown for label in (tick.label1, tick.label2)}
    found = [(text.get_text(), text.get_window_extent(renderer)) for text in figure.findobj(Text)
             if text.get_visible() and text.get_text().strip() and text not in hidden]
    return [(text, box) for text, box in found if box.width > BESIDE and box.height > BESIDE]


def over_each_other(found):
    return [(one, other) for i, (one, a) in enumerate(found) for other, b in found[:i]
            if min(a.x1, b.x1) - max(a.x0, b.x0) > BESIDE and min(a.y1, b.y1) - max(a.y0, b.y0) > BESIDE]


@pytest.fixture(autouse=True)
def closed():
    yield
    pyplot.close("all")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The lap joint of a new folder, run."""
    folder = tmp_path_factory.mktemp("new") / "joint"
    assert main(["new", str(folder)]) == 0
    surroundings = {**SURROUNDINGS, "PYTHONPATH": os.pathsep.join([str(ROOT / "python"), SURROUNDINGS.get("PYTHONPATH", "")])}
    for command in ([sys.executable, "model.py"], [str(BINARY), "run", "case.toml"]):
        subprocess.run(command, cwd=folder, env=surroundings, check=True, capture_output=True)
    return folder


def drawn(folder, monkeypatch, *words):
    """The figure that `plot` would write."""
    figures = []
    monkeypatch.setattr(plot_command, "save_picture", lambda figure, path, **options: figures.append(figure))
    assert main(["plot", *words, "-o", str(folder / "picture.png")]) == 0
    return figures[0]


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("hz", [False, True])
def test_no_text_lies_over_another_or_is_cut_off(folder, monkeypatch, kind, hz):
    figure = drawn(folder, monkeypatch, str(folder / "out/results.h5"), "--kind", kind, *["--hz"] * hz)
    found = texts(figure)
    assert len(found) > 4 and not over_each_other(found)
    for text, box in found:
        assert -BESIDE < box.x0 and box.x1 < figure.bbox.width + BESIDE and -BESIDE < box.y0 and box.y1 < figure.bbox.height + BESIDE, text


def test_texts_that_overlap_are_found(folder, monkeypatch):
    figure = drawn(folder, monkeypatch, str(folder / "out/results.h5"))
    figure.axes[0].text(0.5, 0.5, "one text", transform=figure.axes[0].transAxes)
    figure.axes[0].text(0.52, 0.5, "another", transform=figure.axes[0].transAxes)
    assert ("another", "one text") in over_each_other(texts(figure))


@pytest.mark.parametrize("joints, tall", [(1, False), (1, True), (9, True)])
def test_a_mesh_has_title_and_legend_close_above(tmp_path, joints, tall):
    structure = brick.pair()
    nodes = structure.nodes * ([1, 1, 3] if tall else [3, 1, 0.2])
    joint = {"position": nodes[:joints], "joint": np.arange(joints), "names": [f"joint {i + 1}" for i in range(joints)]}
    figure = mesh_picture({"nodes": nodes, "cells": structure.cells}, joint, title="a bar")
    height = figure.canvas.get_width_height()[1]
    places = [box for text, box in texts(figure) if text == "a bar" or text.startswith("joint ")]
    assert len(places) == 1 + joints and all(0 < box.y0 and box.y1 < height for box in places)
    bbox = plot_command.cropped(figure)["bbox_inches"]
    assert bbox.y1 * figure.dpi > max(box.y1 for box in places)
    if not tall:
        assert bbox.height < 0.6 * figure.get_figheight()


def test_names_of_axes_in_space_are_in_the_picture(folder, monkeypatch):
    figure = drawn(folder, monkeypatch, str(folder / "model.h5"))
    path = folder / "mesh.png"
    axis = figure.axes[0]
    for name in (axis.xaxis.label, axis.yaxis.label, axis.zaxis.label):
        name.set_color("#ff0000")
    figure.savefig(path, **plot_command.cropped(figure))
    picture = Image.open(path).convert("RGB")
    red = [(i % picture.width, i // picture.width) for i, colour in enumerate(picture.getdata()) if colour == (255, 0, 0)]
    assert red and all(2 < x < picture.width - 3 and 2 < y < picture.height - 3 for x, y in red)


@pytest.mark.filterwarnings("error:Glyph")
def test_letters_that_the_font_lacks_come_from_another(tmp_path, monkeypatch, capsys):
    """Of a font that comes with matplotlib. A letter that no font has is named once."""
    monkeypatch.setattr(letters, "KNOWN", {})
    found, none = "\u1d81", "中"
    figure, axis = pyplot.subplots()
    title = figure.suptitle(f"Stoß {found}")
    place_labels(axis, [[(0.5, 0.5, "1")]])  # draws, too
    save_picture(figure, tmp_path / "found.svg")
    assert title.get_fontfamily()[0] == "sans-serif" and len(title.get_fontfamily()) == 2 and letters.KNOWN.keys() == {found}
    assert not any(capsys.readouterr())
    own = [entry for entry in font_manager.fontManager.ttflist if entry.name == "DejaVu Sans"]
    monkeypatch.setattr(font_manager.fontManager, "ttflist", own)
    monkeypatch.setattr(font_manager, "findSystemFonts", list)
    for name in ("once.png", "twice.png"):
        figure, axis = pyplot.subplots()
        axis.plot([0, 1], label=none)
        axis.legend()
        save_picture(figure, tmp_path / name)
    said = capsys.readouterr().err
    assert said.count("no installed font") == 1 and f"has {none}, drawn as boxes" in said
