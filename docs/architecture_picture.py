"""Draws docs/architecture.svg: the path of a scene, and the order of the folders.

    /usr/bin/python3 docs/architecture_picture.py

The script needs nothing but Python. The same script gives the same bytes.
"""
from html import escape
from itertools import groupby
from pathlib import Path

WIDTH, HEIGHT = 1230, 550
INK, GREY, ENGINE, SERVER, CLIENT = "#1b1f24", "#57606a", "#ddf4ff", "#fff8c5", "#dafbe1"

# What a scene becomes: (title, what it is, folder, colour).
PATH = [
    ("Scene", "JSON or proto", "client, proto", CLIENT),
    ("Scene", "checked, immutable", "engine/scene", ENGINE),
    ("Map", "System + Method", "engine/motion", ENGINE),
    ("Simulation", "Map, state, step k", "engine/motion", ENGINE),
    ("Session", "step k to state", "server/sessions", SERVER),
    ("Samples", "tensors, streamed", "server/calls, proto", CLIENT),
]
ARROWS = ["check", "look up", "iterate", "hold under an id", "convert"]

# A folder may include the folders to its left; in the first column of the engine and in those of the server also the
# ones above it: (parent, folders, colour). tests/layout/test_layout.py has the same order.
ORDER = [
    ("engine", ["numbers", "dense", "methods", "scene", "motion"], ENGINE),
    ("engine", ["structure", "growth", "accuracy", "summary"], ENGINE),
    ("engine", ["body", "frame", "bracket"], ENGINE),
    ("server", ["scheduling", "sessions", "sessions/store", "convert"], SERVER),
    ("server", ["connections", "calls", "program"], SERVER),
    ("client", ["cpp", "python", "examples"], CLIENT),
]
def text(x, y, words, size=13, colour=INK, weight="normal", anchor="middle"):
    return (f'<text x="{x:g}" y="{y:g}" font-size="{size}" fill="{colour}" font-weight="{weight}" '
            f'text-anchor="{anchor}">{escape(words)}</text>')


def box(x, y, width, height, colour):
    return (f'<rect x="{x:g}" y="{y:g}" width="{width:g}" height="{height:g}" rx="6" fill="{colour}" '
            f'stroke="{GREY}"/>')


def arrow(x, y, length):
    return f'<line x1="{x:g}" y1="{y:g}" x2="{x + length:g}" y2="{y:g}" stroke="{INK}" marker-end="url(#head)"/>'


def path_of_a_scene(top):
    width, gap = 126, 44
    left = (WIDTH - len(PATH) * width - (len(PATH) - 1) * gap) / 2
    for k, (title, what, folder, colour) in enumerate(PATH):
        x = left + k * (width + gap)
        middle = x + width / 2
        yield box(x, top, width, 64, colour)
        yield text(middle, top + 27, title, 16, weight="bold")
        yield text(middle, top + 48, what, 12)
        yield text(middle, top + 84, folder, 12, GREY)
        if k < len(ARROWS):
            yield arrow(x + width + 3, top + 32, gap - 8)
            yield text(x + width + gap / 2, top - 10, ARROWS[k], 11, GREY)


def order_of_folders(top):
    width, gap, height = 98, 12, 30
    left = (WIDTH - len(ORDER) * width - (len(ORDER) - 1) * gap) / 2
    for k, (_, folders, colour) in enumerate(ORDER):
        x = left + k * (width + gap)
        for row, folder in enumerate(folders):
            y = top + row * (height + 8)
            yield box(x, y, width, height, colour)
            yield text(x + width / 2, y + 20, folder, 12)
    below = top + max(len(folders) for _, folders, _ in ORDER) * (height + 8) + 6
    column = width + gap
    for parent, group in groupby(enumerate(ORDER), lambda numbered: numbered[1][0]):
        columns = [k for k, _ in group]
        start, end = left + columns[0] * column, left + columns[-1] * column + width
        yield f'<line x1="{start:g}" y1="{below}" x2="{end:g}" y2="{below}" stroke="{GREY}"/>'
        yield text((start + end) / 2, below + 20, parent, 13, GREY)


def picture():
    return "\n".join([
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{HEIGHT}" viewBox="0 0 {WIDTH} {HEIGHT}" '
        'font-family="Helvetica, Arial, sans-serif">',
        '<defs><marker id="head" markerWidth="8" markerHeight="8" refX="7" refY="4" orient="auto">'
        f'<path d="M0,0 L8,4 L0,8 z" fill="{INK}"/></marker></defs>',
        f'<rect width="{WIDTH}" height="{HEIGHT}" fill="#ffffff"/>',
        text(12, 30, "The path of a scene", 17, weight="bold", anchor="start"),
        *path_of_a_scene(84),
        text(12, 250, "The order of the folders: each includes at most folders to its left or above it", 17,
             weight="bold", anchor="start"),
        *order_of_folders(280),
        "</svg>",
    ]) + "\n"


if __name__ == "__main__":
    (Path(__file__).parent / "architecture.svg").write_text(picture(), encoding="utf-8")
