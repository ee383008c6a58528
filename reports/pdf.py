"""A report on paper: printed to PDF by the browser that is there."""

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

VARIABLE = "BALLESTA_BROWSER"
_NAMES = (
    *("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome"),
    *("microsoft-edge", "msedge", "brave-browser"),
)
_PLACES = (
    "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome",
    "/Applications/Chromium.app/Contents/MacOS/Chromium",
    "/Applications/Microsoft Edge.app/Contents/MacOS/Microsoft Edge",
    *(
        str(Path(root) / program)
        for root in map(os.environ.get, ("PROGRAMFILES", "PROGRAMFILES(X86)", "LOCALAPPDATA"))
        if root
        for program in (
            "Google/Chrome/Application/chrome.exe",
            "Microsoft/Edge/Application/msedge.exe",
        )
    ),
)
_DRAWN = 20_000  # ms of the page's own clock, until its pictures are drawn
_LONGEST = 180.0  # s


class PrintError(RuntimeError):
    """No browser is there, or it printed nothing; the text says what to do."""


def find_browser() -> str:
    """Return the program that prints: Chromium, Chrome, Edge or Brave.

    `BALLESTA_BROWSER` names another one. Raises PrintError where there is none.
    """
    stated = os.environ.get(VARIABLE)
    if stated:
        found = shutil.which(stated)
        if found is None:
            raise PrintError(f"{VARIABLE} names {stated!r}, which is no program")
        return found
    for name in (*_NAMES, *_PLACES):
        found = shutil.which(name)
        if found is not None:
            return found
    raise PrintError(
        "a PDF is printed by Chromium, Chrome, Edge or Brave, and none was found; install one "
        f"(Debian, Ubuntu: apt-get install -y chromium), or name it in {VARIABLE}"
    )


def print_pdf(report: Path, pdf: Path, browser: str) -> None:
    """Print a report, an HTML file, to a PDF file; one that was there is replaced at the end.

    browser  from `find_browser`

    Raises PrintError where the browser ends without a PDF, and OSError for a file that cannot be
    written.
    """
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as scratch:
        made = Path(scratch) / "report.pdf"
        command = [
            browser, "--headless", "--disable-gpu", "--no-first-run", "--no-pdf-header-footer",
            f"--user-data-dir={scratch}/profile", f"--virtual-time-budget={_DRAWN}",
            f"--print-to-pdf={made}", *_unguarded(), report.resolve().as_uri(),
        ]  # fmt: skip
        try:
            ended = subprocess.run(
                command, capture_output=True, text=True, errors="replace", timeout=_LONGEST,
                check=False,
            )  # fmt: skip
        except subprocess.TimeoutExpired:
            raise PrintError(
                f"{browser} printed nothing within {_LONGEST:.0f} s; open {report} and print it"
            ) from None
        except OSError as error:
            raise PrintError(f"{browser} cannot be started: {error.strerror}") from error
        if not made.is_file() or not made.read_bytes().startswith(b"%PDF"):
            last = next((line for line in reversed(ended.stderr.splitlines()) if line.strip()), "")
            raise PrintError(
                f"{browser} printed nothing (exit code {ended.returncode}{': ' * bool(last)}"
                f"{last.strip()[:200]}); open {report} and print it"
            )
        beside = pdf.with_name(f".{pdf.name}.tmp")
        shutil.copyfile(made, beside)
        beside.replace(pdf)


def _unguarded() -> list[str]:
    """Options without which root cannot print: the browser refuses its sandbox there."""
    if sys.platform != "win32" and os.geteuid() == 0:
        return ["--no-sandbox"]
    return []
