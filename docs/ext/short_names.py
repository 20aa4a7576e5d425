"""Links of short names, and types as written.

Types are shown as the source writes them.
"""

from __future__ import annotations

import inspect
from typing import Any

from docutils import nodes
from sphinx.addnodes import pending_xref
from sphinx.application import Sphinx
from sphinx.environment import BuildEnvironment
from sphinx.util.inspect import stringify_signature
from sphinx.util.nodes import make_refnode
from sphinx.util.typing import stringify_annotation

_KINDS = ("class", "exception", "function")
# other people's types, whose pages the build does not ask for
_ELSEWHERE = {
    "ArrayLike": "https://numpy.org/doc/stable/reference/typing.html#numpy.typing.ArrayLike",
    "FloatArray": "https://numpy.org/doc/stable/reference/generated/numpy.ndarray.html",
    "numpy.ndarray": "https://numpy.org/doc/stable/reference/generated/numpy.ndarray.html",
    "numpy.dtype": "https://numpy.org/doc/stable/reference/generated/numpy.dtype.html",
    "numpy.float64": "https://numpy.org/doc/stable/reference/arrays.scalars.html#numpy.float64",
    "pd.DataFrame": "https://pandas.pydata.org/docs/reference/api/pandas.DataFrame.html",
    "Figure": "https://matplotlib.org/stable/api/figure_api.html#matplotlib.figure.Figure",
    "Axes": "https://matplotlib.org/stable/api/axes_api.html#matplotlib.axes.Axes",
    "FilePath": "https://docs.python.org/3/library/pathlib.html#pathlib.Path",
    "Callable": "https://docs.python.org/3/library/collections.abc.html#collections.abc.Callable",
    "Iterable": "https://docs.python.org/3/library/collections.abc.html#collections.abc.Iterable",
    "Sequence": "https://docs.python.org/3/library/collections.abc.html#collections.abc.Sequence",
}


def resolve(
    app: Sphinx, env: BuildEnvironment, node: pending_xref, content: nodes.TextElement
) -> nodes.reference | None:
    """The entry whose last part is the name.

    Types of others lead to their own pages. None unless there is exactly one entry.
    """
    if node.get("refdomain") != "py":
        return None
    if address := _ELSEWHERE.get(node["reftarget"]):
        return nodes.reference("", "", content, internal=False, refuri=address)
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
    """A signature with types as in the source.

    It says `ArrayLike`, not all that it stands for.

    A name for a kind of function is written out; of a record of a manifest the fields are named.
    """
    if not callable(obj) or not signature:
        return None
    if hasattr(obj, "model_fields"):
        return f"({', '.join(obj.model_fields)})", None
    written = inspect.signature(obj)
    alias = getattr(obj, "__globals__", {}).get("Progress")
    if alias and "progress" in written.parameters:
        given = written.parameters["progress"]
        annotation = str(given.annotation).replace("Progress", stringify_annotation(alias, "smart"))
        progress = given.replace(annotation=annotation.replace("~collections.abc.", ""))
        written = written.replace(
            parameters=[progress if p is given else p for p in written.parameters.values()]
        )
    if what == "method":
        written = written.replace(parameters=list(written.parameters.values())[1:])
    annotation = written.return_annotation
    text = stringify_signature(written, show_return_annotation=False)
    returned = annotation if isinstance(annotation, str) and what != "class" else None
    return text, returned


def setup(app: Sphinx) -> dict[str, Any]:
    """Register both functions with Sphinx.

    `resolve` is asked for names that Sphinx does not find, `as_written` for every signature.
    """
    app.connect("missing-reference", resolve)
    app.connect("autodoc-process-signature", as_written)
    return {"parallel_read_safe": True}
