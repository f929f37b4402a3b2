"""Coverage tables for people."""

from viewgain.evaluation._bootstrap import Shares
from viewgain.evaluation._coverage import CoverageTable
from viewgain.evaluation._markdown import markdown_table
from viewgain.evaluation._play import FARTHEST, RULES

_WORDS = {
    "union": "By union: each sample of the surface counts once.",
    "published": "By the published rule, which counts some samples twice:",
}


def coverage_to_markdown(table: CoverageTable) -> str:
    """Return the table as Markdown: what it is about, then one table for each rule of counting."""
    skipped = f"; {len(table.skipped)} skipped" if table.skipped else ""
    lines = [
        f"## Coverage, {table.views} views, {table.steps} steps: {table.title}",
        "",
        f"Data: {table.data}; {table.objects:,} objects of {table.categories:,} categories{skipped}; rig {table.rig}; the same"
        " random first view for all.",
        f"AUC: area under coverage by views, 0 to {table.steps}, per view. Gap: between random and the greedy oracle (by union),"
        " of the means. 95 % intervals by objects drawn anew, paired where two policies are compared.",
    ]
    for rule in RULES:
        header = (
            "policy",
            "AUC",
            "mean over categories",
            "gap closed",
            f"minus {FARTHEST}",
            f"coverage after 1 to {table.steps} views",
        )
        rows = [
            (
                row.policy,
                _interval(row.auc, "{:.4f}"),
                f"{row.auc_by_category:.4f}",
                "" if row.closed is None else _interval(row.closed, "{:.1%}"),
                _interval(row.over_farthest, "{:+.4f}"),
                " ".join(f"{each:.3f}" for each in row.coverage),
            )
            for row in table.rows
            if row.rule == rule
        ]
        lines += ["", _WORDS[rule], "", *markdown_table(header, rows)]
    return "\n".join(lines) + "\n"


def _interval(shares: Shares, form: str) -> str:
    return f"{form.format(shares.mean[0])} ({form.format(shares.low[0])} to {form.format(shares.high[0])})"
