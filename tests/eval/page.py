"""Writes what the stages left into a Markdown page: between `<!-- NAME -->` and `<!-- end of NAME -->`, for each stage, what it was
measured on, its table and what is found."""
import re
import textwrap

import findings
import report
import spread

WIDTH = 118


def table(columns, lines):
    rows = [columns, ["---"] * len(columns), *([report.cell(value) for value in line] for line in lines)]
    return "\n".join("| " + " | ".join(row) + " |" for row in rows)


def of_report(chapter):
    """The chapter's tables and findings as the report has them."""
    def parts(out):
        for part in chapter(out):
            if isinstance(part, report.Table):
                yield table(part.columns, part.rows)
            elif isinstance(part, report.Here):
                yield textwrap.fill(part.text, WIDTH)
    return parts


def automatic(out):
    """The findings alone: the table has some forty rows a scene."""
    return [textwrap.fill(part.text, WIDTH) for part in report.automatic(out) if isinstance(part, report.Here)]


def remote(out):
    """A table for each scene; a cell has visibility's figure before video's."""
    rows = report.remote_rows(out)
    if not rows:
        return
    figures = {column: spread.by(rows, column, "scene", *report.LINK, "mode") for column in report.REMOTE}
    columns = [column for column in ("response_ms", "late_share", "ssim", "vmaf", "mbit_per_s") if figures[column]]
    for scene in dict.fromkeys(row["scene"] for row in rows):
        links = sorted({key[1:4] for key in figures["response_ms"] if key[0] == scene})
        lines = []
        for loss, ms, mbit in links:
            pair = [(scene, loss, ms, mbit, mode) for mode in ("visibility", "video")]
            lines.append([f"{loss:.0f}%, {ms:.0f} ms, {mbit:.0f}",
                          *("; ".join(figures[c][key].text(report.REMOTE[c][1]) if key in figures[c] else "-" for key in pair) for c in columns)])
        yield table([f"{scene}: loss, round trip, Mbit/s", *(report.REMOTE[c][0] for c in columns)], lines)
    yield textwrap.fill(findings.of_remote(figures), WIDTH)


STAGES = {"rates": of_report(report.rates), "clients": of_report(report.clients), "response": of_report(report.response),
          "videos": of_report(report.videos), "auto": automatic, "remote": remote}


def section(out, machine, stage):
    parts = list(STAGES[stage](out))
    if not parts:
        return None
    where = report.measured_on(machine[stage], stage).split("; ")
    return "\n\n".join([f"*{'; '.join(f'`{part}`' if part.startswith('tests/') else part for part in where)}*", *parts])


def filled(text, out, machine):
    for stage in STAGES:
        made = section(out, machine, stage) if stage in machine else None
        if made:
            text = re.sub(rf"(<!-- {stage} -->\n).*?(<!-- end of {stage} -->)", lambda m: f"{m[1]}{made}\n{m[2]}", text, flags=re.S)
    return text


def write(page, out, machine):
    page.write_text(filled(page.read_text(), out, machine))
