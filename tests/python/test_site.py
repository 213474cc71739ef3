"""The documents as a site: every page of the index is in its contents and is found by its search."""

import http.server
import json
import re
import shutil
import subprocess
import sys
import threading
from functools import partial

import pytest

from headless import browser, complaints, needs_browser, until
from launch import ROOT, SECONDS

sys.path.insert(0, str(ROOT / "scripts"))
import site_pages

HTML = ROOT / "build/site/html"


def test_items_of_lists_stand_as_far_in_as_the_site_wants_them():
    text = "- one\n  more\n  - below\n\n  a paragraph\n\nAfter:\n\n    formula\n\n1. first\n   ```sh\n   run\n   ```\n"
    wanted = "- one\n    more\n    - below\n\n    a paragraph\n\nAfter:\n\n    formula\n\n1. first\n      ```sh\n      run\n      ```\n"
    assert site_pages.indented(text) == wanted


@pytest.fixture(scope="module")
def made():
    if not shutil.which("mkdocs"):
        pytest.skip("mkdocs is not installed: scripts/setup installs it where the distribution has it")
    subprocess.run([ROOT / "scripts/site"], check=True, timeout=SECONDS, capture_output=True)


class Handler(http.server.SimpleHTTPRequestHandler):
    def log_message(self, *_):
        pass


@pytest.mark.slow
def test_every_page_is_found(made):
    found = {entry["location"].split("#")[0] for entry in json.loads((HTML / "search/search_index.json").read_text())["docs"]}
    front = (HTML / "index.html").read_text()
    pages = [page for section in site_pages.contents() for group in section.values() for page in group]
    assert len(pages) > 50 and not re.search(r">\s*None\s*<", front)
    for page in pages:
        place = page.removesuffix(".md").removesuffix("README") + (".html" if not page.endswith("README.md") else "index.html")
        assert place in found and f'href="{place}"' in front, page


@pytest.mark.slow
@needs_browser
def test_the_search_leads_to_a_page(made):
    def answers():
        """Where the answers lead: read at once, as each letter that is typed replaces them."""
        read = "return [...document.querySelectorAll('.md-search-result__link')].map(link => link.href)"
        return [place for place in driver.execute_script(read) if "docs/how-to/stress.html" in place]

    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), partial(Handler, directory=HTML)) as server, browser() as driver:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        driver.get(f"http://127.0.0.1:{server.server_port}/")
        driver.find_element("css selector", ".md-search__input").send_keys("Goodman")
        driver.get(until(driver, answers, "an answer")[0])
        assert "Goodman" in driver.find_element("css selector", "article").text and not complaints(driver)
        server.shutdown()
