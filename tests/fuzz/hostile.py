"""Texts and values that no honest file holds."""

from hypothesis import HealthCheck, settings
from hypothesis import strategies as st

# Fixtures that live longer than one case are meant.
LONG_LIVED = settings(suppress_health_check=list(HealthCheck))


# what must never stand in a page or on a terminal as it is
MARK = "evil7"
HOSTILE = (
    f"<script>{MARK}()</script>",
    f"<img src=x onerror={MARK}()>",
    f'"><iframe src="javascript:{MARK}()"></iframe>',
    f"' onmouseover='{MARK}()",
    f"</title></style></svg><svg onload={MARK}()>",
    f"]]><script>{MARK}()</script>",
    f"{{{{ {MARK}.__class__ }}}}{{% raw %}}",
    f"[{MARK}](javascript:alert(1)) ![x](http://{MARK}.example/x.png)",
    f"| a | {MARK} |\n|---|---|\n# {MARK}",
    f"\\input{{/etc/passwd}}\\write18{{touch {MARK}}}$x^{{2}}$%",
    f"\x1b[31m{MARK}\x1b[0m\x1b]0;{MARK}\x07",
    f"\r{MARK}\x08\x7f\x9b31m",
    f"../../{MARK}",
    f"/{MARK}/{MARK}",
    f"..\\..\\{MARK}",
    f"a\x00{MARK}",
    f"\u202e{MARK}\u2066\ufeff",
    f"=cmd|'/c {MARK}'!A1",
    "$\\frac{1}$ $ \\undefined",
    "[/red][bold]" + MARK,
    "%s%n{0}{x!r}",
    "a" * 5000,
    f"s[{','.join(f'k{i}=1' for i in range(500))}]",
    "",
    " ",
    ".",
    "..",
    "*",
    "-",
    "--trust-plugins",
    "𝔘\u0301\u0301\u0301",
)

texts = st.one_of(st.sampled_from(HOSTILE), st.text(max_size=20))
