"""Hooks of mkdocs (mkdocs.yml): README.md is the first page, linked designs are files of the site.

A page that would load anything from the network ends the build.
"""

import re
from pathlib import Path
from typing import Any

from mkdocs.exceptions import PluginError
from mkdocs.structure.files import File, Files

ROOT = Path(__file__).parent.parent
_DESIGN = re.compile(r"\]\(\.\./(designs/[^)#]+)\)")
# what a browser fetches by itself, unlike the target of a link that a reader may follow
_LOADED = re.compile(
    r"""<(?:script|img|link|iframe)\b[^>]*\b(?:src|href)=["']?(?:https?:)?//[^>]*>"""
)


def on_files(files: Files, config: Any) -> Files:
    """Add README.md as index.md, and every design that a page links."""
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    files.append(File.generated(config, "index.md", content=readme.replace("](docs/", "](")))
    texts = [file.content_string for file in files.documentation_pages()]
    linked = {design for text in texts for design in _DESIGN.findall(text)}
    for design in sorted(linked):
        files.append(File.generated(config, design, abs_src_path=str(ROOT / design)))
    return files


def on_page_markdown(markdown: str, **_: Any) -> str:
    """Links out of docs/ as links within the site."""
    return markdown.replace("](../README.md", "](index.md").replace("](../designs/", "](designs/")


def on_post_page(output: str, page: Any, **_: Any) -> str:
    """The page as it is; raises PluginError where a browser would load something for it."""
    if found := _LOADED.search(output):
        raise PluginError(f"{page.file.src_uri} loads from the network: {found[0]}")
    return output
