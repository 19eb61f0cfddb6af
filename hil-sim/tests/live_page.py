"""Opens the live view's page in a browser while a run is going on, and stays
until the run after it.

usage: live_page.py URL NAME NEXT_NAME PICTURE
"""

import sys
from urllib.parse import urlsplit

from browser import Browser

PLOTS = {
    "plane": ["path", "track", "robot"],
    "error-chart": ["line-response"],
    "torque-chart": ["line-right", "line-left", "limit-1", "limit--1"],
    "load-chart": ["line-response"],
}


def main(url, name, next_name, picture):
    with Browser(url) as page:
        page.wait_for(f"document.title === '{name}, live'")
        it_shows_the_run(page)
        the_numbers_move(page)
        the_plots_are_visible(page)
        page.screenshot(f"{picture}.png")
        page.screenshot(f"{picture}-dark.png", dark=True)
        assert page.complaints == [], page.complaints
        print("goes on", flush=True)

        page.wait_for("text('connection').includes('this is its last state')")
        assert "interrupted" in page.value("text('connection')")
        time = page.value("text('time')")
        assert float(time) > 0 and page.value("text('state')") == "running", time
        the_plots_are_visible(page)
        print("last state", flush=True)

        page.wait_for(f"document.title === '{next_name}, live' && text('connection') === 'live'")
        page.wait_for("Number(text('time')) > 0.5")
        the_plots_are_visible(page)
        assert "a push" not in page.value("text('happened')"), "that was in the run before"
        here = urlsplit(url).netloc
        assert {urlsplit(request).netloc for request in page.requests} == {here}, page.requests


HELPERS = """
window.text = (id) => document.getElementById(id).textContent;
window.size = (plot, name) => {
    const part = document.getElementById(plot).parts.get(name);
    if (!part) return 0;
    const { width, height } = part.getBBox();
    return Math.max(width, height);
};
"""


def it_shows_the_run(page):
    page.value(HELPERS)
    page.wait_for("text('state') === 'running' && text('drive-right') === 'enabled'")
    page.wait_for("text('happened').includes('a push begins')")
    assert page.value("text('connection')") == "live"
    assert 5 < page.value("Number(text('load'))") < 50
    assert page.value("Number(text('position-error'))") < 100
    rows = page.value("[...document.getElementById('wheels').rows].map((row) => row.innerText.split('\\t'))")
    assert [row[0] for row in rows] == ["speed", "speed wanted", "torque wanted", "torque sent", "torque applied"], rows
    assert all(float(row[1].replace("\u2212", "-")) != 0 for row in rows[:2]), rows
    assert "updates missed by slow viewers" in page.value("text('lost')")


def the_numbers_move(page):
    for what in ("time", "frames", "position-error"):
        before = page.value(f"text('{what}')")
        page.wait_for(f"text('{what}') !== '{before}'")
    before = page.value("document.getElementById('plane').parts.get('robot').getAttribute('transform')")
    page.wait_for(f"document.getElementById('plane').parts.get('robot').getAttribute('transform') !== '{before}'")
    page.wait_for("size('error-chart', 'line-response') > 100")


def the_plots_are_visible(page):
    for plot, parts in PLOTS.items():
        box = page.value(f"document.getElementById('{plot}').getBoundingClientRect().toJSON()")
        assert box["width"] > 300 and box["height"] > 100, (plot, box)
        for part in parts:
            page.wait_for(f"size('{plot}', '{part}') > 1")
            style = page.value(
                f"(({{ stroke, display }}) => [stroke, display])"
                f"(getComputedStyle(document.getElementById('{plot}').parts.get('{part}')))"
            )
            assert style[0] != "none" and style[1] != "none", (plot, part, style)


main(*sys.argv[1:])
