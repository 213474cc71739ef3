"""The documents as a site: every page of the index is in its contents and is found by its search."""

import json
import shutil
import subprocess
import sys

import pytest

from launch import ROOT, SECONDS

sys.path.insert(0, str(ROOT / "scripts"))
import site_pages

HTML = ROOT / "build/site/html"


def test_items_of_lists_stand_as_far_in_as_the_site_wants_them():
    text = "- one\n  more\n  - below\n\n  a paragraph\n\nAfter:\n\n    formula\n\n1. first\n   ```sh\n   run\n   ```\n"
    wanted = "- one\n    more\n    - below\n\n    a paragraph\n\nAfter:\n\n    formula\n\n1. first\n      ```sh\n      run\n      ```\n"
    assert site_pages.indented(text) == wanted


@pytest.mark.slow
@pytest.mark.skipif(not shutil.which("mkdocs"), reason="mkdocs is not installed: scripts/setup installs it where the distribution has it")
def test_every_page_is_found():
    subprocess.run([ROOT / "scripts/site"], check=True, timeout=SECONDS, capture_output=True)
    found = {entry["location"].split("#")[0] for entry in json.loads((HTML / "search/search_index.json").read_text())["docs"]}
    front = (HTML / "index.html").read_text()
    pages = [page for section in site_pages.contents() for group in section.values() for page in group]
    assert len(pages) > 50
    for page in pages:
        place = page.removesuffix(".md").removesuffix("README") + (".html" if not page.endswith("README.md") else "index.html")
        assert place in found and f'href="{place}"' in front, page
