"""A page in a real Chromium, and what may not happen on it."""

from __future__ import annotations

from typing import Any

from playwright.sync_api import Browser, BrowserContext, Page

PHONE, DESK = {"width": 400, "height": 800}, {"width": 1280, "height": 900}


class Tab:
    """A page in the browser; `close` fails if it logged an error or asked for anything remote."""

    def __init__(self, browser: Browser, **options: Any) -> None:
        self.context: BrowserContext = browser.new_context(**options)
        self.page: Page = self.context.new_page()
        self.errors: list[str] = []
        self.page.on("pageerror", lambda error: self.errors.append(str(error)))
        self.page.on("console", lambda line: line.type == "error" and self.errors.append(line.text))
        self.page.on(
            "request",
            lambda request: request.url.startswith("http") and self.errors.append(request.url),
        )
        self.page.on("dialog", self._dialog)

    def _dialog(self, dialog: Any) -> None:
        self.errors.append(f"a dialog: {dialog.message}")  # text from outside was run as a script
        dialog.dismiss()

    def close(self) -> None:
        self.context.close()
        assert not self.errors, self.errors
