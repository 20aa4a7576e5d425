"""Short names lead to their entries, and types are shown as the source writes them."""

from __future__ import annotations

import inspect
from typing import Any

from docutils import nodes
from sphinx.addnodes import pending_xref
from sphinx.application import Sphinx
from sphinx.environment import BuildEnvironment
from sphinx.util.inspect import stringify_signature
from sphinx.util.nodes import make_refnode

_KINDS = ("class", "exception", "function")


def resolve(
    app: Sphinx, env: BuildEnvironment, node: pending_xref, content: nodes.TextElement
) -> nodes.reference | None:
    """The entry whose last part is the name that is asked for, if there is exactly one."""
    if node.get("refdomain") != "py":
        return None
    name = node["reftarget"].rpartition(".")[2]
    objects = env.get_domain("py").get_objects()
    entries = [o for o in objects if o[0].rpartition(".")[2] == name and o[2] in _KINDS]
    if len(entries) != 1:
        return None
    _, _, _, page, anchor, _ = entries[0]
    return make_refnode(app.builder, node["refdoc"], page, anchor, content)


def as_written(
    app: Sphinx, what: str, name: str, obj: Any, options: Any, signature: str, returns: str
) -> tuple[str, str | None] | None:
    """A signature with types as in the source: `ArrayLike`, not all that it stands for."""
    if not callable(obj) or not signature:
        return None
    written = inspect.signature(obj)
    if what == "method":
        written = written.replace(parameters=list(written.parameters.values())[1:])
    annotation = written.return_annotation
    text = stringify_signature(written, show_return_annotation=False)
    returned = annotation if isinstance(annotation, str) and what != "class" else None
    return text, returned


def setup(app: Sphinx) -> dict[str, Any]:
    """Ask `resolve` for names that Sphinx does not find, `as_written` for every signature."""
    app.connect("missing-reference", resolve)
    app.connect("autodoc-process-signature", as_written)
    return {"parallel_read_safe": True}
