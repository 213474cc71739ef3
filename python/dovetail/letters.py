"""Letters that the font of a picture lacks, such as Chinese ones: taken from any installed font that has them."""

import functools
import sys
import warnings

KNOWN = {}  # name of the font of each letter that was looked for; None: no font has it


def lend_letters(figure):
    """Gives texts of a figure a further font where theirs lacks letters; says once of a letter that no font has it."""
    from matplotlib import font_manager
    from matplotlib.text import Text

    lacking = {}
    for text in figure.findobj(lambda artist: isinstance(artist, Text) and not artist.get_text().isascii()):
        has = _letters_of(font_manager.findfont(text.get_fontproperties()))
        lacking[text] = {letter for letter in text.get_text() if letter.isprintable()} - has
    if unknown := set().union(*lacking.values()) - KNOWN.keys():
        _look_for(unknown)
    for text, letters in lacking.items():
        further = sorted({KNOWN[letter] for letter in letters} - {None})
        text.set_fontfamily(list(dict.fromkeys([*text.get_fontfamily(), *further])))


def _look_for(letters):
    """Puts letters into KNOWN: those that many have together into one font."""
    from matplotlib.font_manager import findSystemFonts, fontManager

    for path in sorted(set(findSystemFonts()) - {entry.fname for entry in fontManager.ttflist}):  # installed since matplotlib looked
        try:
            fontManager.addfont(path)
        except (OSError, RuntimeError):
            continue
    covered = {}
    for entry in sorted(fontManager.ttflist, key=lambda entry: ("Sans" not in entry.name, entry.name)):
        if not entry.name.startswith(("LastResort", "Last Resort")):  # whose letters are boxes
            covered[entry.name] = covered.get(entry.name, set()) | letters & _letters_of(entry.fname)
            if covered[entry.name] == letters:
                break
    for name in sorted(covered, key=lambda name: -len(covered[name])):
        for letter in covered[name]:
            KNOWN.setdefault(letter, name)
    if lost := "".join(sorted(letters - KNOWN.keys())):
        KNOWN.update(dict.fromkeys(lost))
        print(f"note: no installed font has {lost}, drawn as boxes; install one that does, such as the package fonts-noto-cjk for Chinese, "
              "Japanese and Korean", file=sys.stderr)
        warnings.filterwarnings("ignore", r"Glyph \d+")  # matplotlib's words for the same


@functools.cache
def _letters_of(path):
    """The letters of a font file; none where it cannot be drawn from."""
    from matplotlib.font_manager import get_font

    try:
        return frozenset(map(chr, get_font(path).get_charmap()))
    except (OSError, RuntimeError):
        return frozenset()
