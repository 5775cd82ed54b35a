#!/usr/bin/env python3
"""Checks a page of accel-trace --report against the JSON of the same run.

usage: report_page.py PAGE.html RUN.json             every number in a table is the JSON's, and nothing is fetched
       report_page.py PAGE.html RUN.json DOM.html    and so is every mark that a browser drew, as its --dump-dom tells
"""
import json
import re
import sys
from html.parser import HTMLParser

UNITS = {"us": 1e-6, "ms": 1e-3, "s": 1, "B": 1, "KiB": 2**10, "MiB": 2**20, "GiB": 2**30, "%": 1e-2}


def check(is_true, what):
    if not is_true:
        sys.exit("report_page.py: " + what)


class Page(HTMLParser):
    """Cells with numbers, scripts, pictures, headings, and what is loaded from elsewhere."""

    def __init__(self, text):
        super().__init__()
        self.cells, self.scripts, self.images, self.loads, self.tables, self.captions = [], [], [], [], 0, 0
        self.html_class, self.open = "", None
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        a = dict(attributes)
        if tag == "html":
            self.html_class = a.get("class", "")
        self.tables += tag == "table"
        self.captions += tag == "caption"
        if tag == "img":
            self.images.append(a)
        self.loads += [a[key] for key in ("src", "href") if key in a and tag != "a" and not a[key].startswith("data:")]
        if tag in ("td", "script"):
            self.open = (tag, a, [])

    def handle_data(self, data):
        if self.open:
            self.open[2].append(data)

    def handle_endtag(self, tag):
        if not self.open or tag != self.open[0]:
            return
        _, a, parts = self.open
        self.open = None
        if tag == "script":
            self.scripts.append((a, "".join(parts)))
        elif "data-json" in a:
            self.cells.append((a, "".join(parts)))


def at(document, pointer):
    for key in pointer.split("/")[1:]:
        document = document[int(key)] if isinstance(document, list) else document[key]
    return document


def shown(text):
    """The number that a cell shows: "< 61.0", "1,234", "12.3 MiB", "2 min 03 s"."""
    words = text.replace(",", "").replace("<", " ").split()
    if "min" in words:
        return 60 * float(words[0]) + float(words[2])
    return float(words[0]) * (UNITS[words[1]] if len(words) > 1 else 1)


def is_near(a, b):
    """Equal to the three digits that people read, or to a hundredth."""
    return abs(a - b) <= max(6e-3 * abs(b), 5.1e-3 if abs(b) < 1 else 0)


def check_cells(page, run):
    for a, text in page.cells:
        value = at(run, a["data-json"])
        if "data-over" in a:
            value /= at(run, a["data-over"])
        if "data-inverse" in a:
            value = float(a["data-inverse"]) / value
        if a["data-json"].endswith("_ms"):
            value *= 1e-3
        check(is_near(shown(text), value), "a cell says %s for %s, which is %r" % (text, a, value))


def number(text):
    return float(text.replace(",", "").replace("\u2212", "-"))


def rows_of(run):
    return [row for row in run["benchmarks"] if "sort" not in row]


def specs(page):
    return [json.loads(text) for a, text in page.scripts if a.get("type") == "application/json" and "id" not in a]


def check_specs(page, run):
    """The numbers that plots are made from."""
    label = lambda row: row["method"] + (" + " + row["test"] if row["name"].endswith("/" + row.get("test", "/")) else "")
    by_name = {(row["rays_kind"], label(row)): row for row in rows_of(run)}
    for spec in specs(page):
        for value in spec["data"]["values"]:
            row = by_name.get((value.get("rays"), value.get("label", "")))
            if "mrays" in value:
                check([value["mrays"], value["least"], value["most"]] == [row["mrays_per_second"], row["mrays_min"], row["mrays_max"]],
                      "a bar is not the JSON's: %r" % value)
            if "ns" in value:
                check(abs(value["ns"] * row["mrays_per_second"] - 1e3) < 1e-6, "a mark is not the JSON's: %r" % value)
                if value["role"] == "ours":
                    check(value["wrong"] == row.get("error", {}).get("per_million", row["wrong_per_million"]), "a mark has other errors than the JSON: %r" % value)


def check_drawing(dom, page, run):
    """What a browser drew: every mark says its numbers to those who do not see it."""
    check("all-drawn" in dom.html_class.split(), "not all plots were drawn")
    text = open(sys.argv[3], encoding="utf-8").read()
    check(text.count("<svg") >= len(specs(page)) > 0, "a plot is missing")
    marks = lambda what: [dict(re.findall(r"([^:;]+): ([^;]*)(?:; |$)", m))
                          for m in re.findall(r'aria-label="([^"]*)" role="graphics-symbol" aria-roledescription="%s"' % what, text)]
    points = [(m["method"], number(m["ns"])) for m in marks("point") if "method" in m]
    ours = sorted((row["method"], 1e3 / row["mrays_per_second"]) for row in rows_of(run)
                  if "wrong_per_million" in row and not row["method"].startswith("Embree"))
    check(len(points) == len(ours) > 0, "%d marks for %d rows" % (len(points), len(ours)))
    for (method, ns), (expected_method, expected) in zip(sorted(points), ours):
        check(method == expected_method and is_near(ns, expected), "%s at %g ns was drawn for %s at %g" % (method, ns, expected_method, expected))
    bars = sorted(number(m["mrays"]) for m in marks("bar") if "mrays" in m)
    check(len(bars) == len(rows_of(run)), "%d bars for %d rows" % (len(bars), len(rows_of(run))))
    for bar, expected in zip(bars, sorted(row["mrays_per_second"] for row in rows_of(run))):
        check(is_near(bar, expected), "a bar of %g was drawn for %g" % (bar, expected))


def main():
    page = Page(open(sys.argv[1], encoding="utf-8").read())
    run = json.load(open(sys.argv[2], encoding="utf-8"))
    carried = [text for a, text in page.scripts if a.get("id") == "numbers"]
    check(len(carried) == 1 and json.loads(carried[0]) == run, "the page carries another JSON")
    check(not page.loads, "the page loads %s" % page.loads)
    check(page.tables >= 4 and page.captions == page.tables, "tables or captions are missing")
    check(len(page.cells) > 20, "too few numbers")
    check(all(image.get("alt") for image in page.images), "a picture has no text")
    check_cells(page, run)
    check_specs(page, run)
    if len(sys.argv) > 3:
        check_drawing(Page(open(sys.argv[3], encoding="utf-8").read()), page, run)


main()
