"""Setting a tree: sizes, places and spaces as TeX has them (Knuth, The TeXbook, appendix G).

The constants are those of the STIX fonts, in thousandths of an em.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from fractions import Fraction as Ratio
from functools import cache

from . import boxes
from .boxes import EMPTY, Box, joined, letters, overlaid, raised, rule, scaled, space
from .glyphs import glyph, has
from .latex import (
    BIN,
    CLOSE,
    GRIDS,
    INNER,
    OP,
    OPEN,
    ORD,
    PUNCT,
    REL,
    Accent,
    Fenced,
    Fraction,
    Grid,
    Node,
    Root,
    Row,
    Scripts,
    Space,
    Symbol,
    Words,
    parse,
)  # fmt: skip

AXIS = 258  # height of fraction bars and of the middle of brackets
X_HEIGHT = 450
BAR = 60  # thickness of a fraction bar and of the line of a root
SUP_UP, SUP_DROP, SUP_LEAST = 380, 230, 120
SUB_DOWN, SUB_DROP, SUB_MOST = 190, 120, 368
SUB_SUP_GAP = 150
NUMERATOR_UP, DENOMINATOR_DOWN = {True: 640, False: 500}, {True: 660, False: 490}  # by display
GAP = {True: 150, False: 80}  # between bar and numerator
ROOT_GAP = {True: 140, False: 90}
SCALES = (1, Ratio(7, 10), Ratio(55, 100))  # of text, scripts, scripts of scripts
THIN, MEDIUM, THICK = 167, 222, 278
SIZES = "rstuv"

# space between two classes, a row for each left one: 1 thin, 2 medium, 3 thick
_SPACES = ("01230001", "11030001", "22002002", "33003003", "00000000", "01230001", "11011111", "11231011")
#          ORD         OP          BIN         REL         OPEN        CLOSE       PUNCT       INNER


@dataclass(frozen=True)
class Style:
    """Size of a part: 0 of text, 1 of scripts, 2 of scripts of scripts; ``display`` leaves more room."""

    level: int = 0
    display: bool = True

    @property
    def script(self) -> Style:
        """The style of a script."""
        return Style(min(2, self.level + 1), False)

    @property
    def part(self) -> Style:
        """The style of a numerator."""
        return replace(self, display=False) if self.display else self.script


@dataclass(frozen=True)
class Atom:
    """A set node in a row: its box and its class.

    Brackets have no space around them: in front they are an opening bracket, behind a closing one.
    """

    box: Box
    kind: int
    node: Node

    @property
    def end(self) -> int:
        """The class towards what follows."""
        node = self.node.base if isinstance(self.node, Scripts) else self.node
        return CLOSE if isinstance(node, Fenced) else self.kind


def scale(style: Style, inside: Style) -> float:
    """Return the size of a part in relation to the whole."""
    return float(Ratio(SCALES[inside.level]) / SCALES[style.level])


def part(node: Node, style: Style, inside: Style) -> Box:
    """Return a part of a node in units of the whole."""
    return scaled(setting(node, inside), scale(style, inside))


def setting(node: Node, style: Style) -> Box:
    """Return a node as a box; one em of its own style is 1000."""
    return _setting(node, style)


@cache
def _setting(node: Node, style: Style) -> Box:
    match node:
        case Row():
            return joined(spaced(atoms(node, style), style))
        case Symbol():
            return boxes.named(_symbol(node, style)) if len(node.text) > 1 else _symbol(node, style)
        case Space():
            return space(node.width)
        case Words():
            return words(node.text)
        case Scripts():
            return boxes.named(scripts(node, style)) if is_name(node) else scripts(node, style)
        case Accent():
            return boxes.named(accented(node, style)) if is_name(node) else accented(node, style)
        case Fraction():
            return fraction(node, style)
        case Root():
            return root(node, style)
        case Fenced():
            body = setting(node.body, style)
            left, right = fences(node, body)
            return joined([left, body, right])
        case Grid():
            return grid(node, style)


def is_name(node: Node) -> bool:
    """Return whether a node is a symbol, with dots and a subscript or without."""
    match node:
        case Symbol():
            return node.kind == ORD
        case Accent():
            return is_name(node.body)
        case Scripts():
            return node.sup is None and node.sub is not None and is_name(node.base) and _is_plain(node.sub)
        case _:
            return False


def _is_plain(node: Node) -> bool:
    if isinstance(node, Row):
        return all(isinstance(x, Symbol | Space | Words) for x in node.nodes)
    return is_name(node)


# -- rows --------------------------------------------------------------------------------------------------


def kind_of(node: Node) -> int:
    """Return the class of a node."""
    match node:
        case Symbol():
            return node.kind
        case Scripts():
            return kind_of(node.base)
        case Fenced():
            return OPEN
        case Fraction():
            return INNER
        case _:
            return ORD


def atoms(node: Node, style: Style) -> list[Atom]:
    """Return the nodes of a row, set; rows in it are opened, signs without a left side have no space."""
    return classified([Atom(setting(x, style), kind_of(x), x) for x in opened(node)])


def opened(node: Node) -> list[Node]:
    """Return the nodes of a row and of the rows in it."""
    return [x for part in node.nodes for x in opened(part)] if isinstance(node, Row) else [node]


def classified(row: list[Atom]) -> list[Atom]:
    """Return atoms in which a sign before its only operand is no binary operation."""
    result: list[Atom] = []
    for atom in row:
        last = next((a.end for a in reversed(result) if not isinstance(a.node, Space)), OPEN)
        if atom.kind == BIN and last in (BIN, OP, REL, OPEN, PUNCT):
            atom = replace(atom, kind=ORD)
        result.append(atom)
    return result


def spaced(row: list[Atom], style: Style) -> list[Box]:
    """Return the boxes of atoms, each with the space before it."""
    result: list[Box] = []
    last: int | None = None
    explicit = False
    for atom in row:
        if isinstance(atom.node, Space):
            explicit = True
            result.append(atom.box)
            continue
        width = (
            0 if last is None or explicit and last == ORD == atom.kind else between(last, atom.kind, style)
        )
        result.append(joined([space(width), atom.box]) if width else atom.box)
        last, explicit = atom.end, False
    return result


def between(left: int, right: int, style: Style) -> int:
    """Return the space between two classes."""
    amount = int(_SPACES[left][right])
    if style.level and OP not in (left, right):
        return 0  # scripts are set tight
    return (0, THIN, MEDIUM, THICK)[amount]


def _symbol(node: Symbol, style: Style) -> Box:
    if node.kind == OP and node.text in "∫∑∏":
        size = "s" if style.display and has("s", node.text) else "r"
        box = letters(node.text, size)
        return raised(box, AXIS - (box.height - box.depth) / 2)
    return letters(node.text, node.style)


def words(text: str) -> Box:
    """Return upright words."""
    return letters(text, "r") if text else EMPTY


def line(text: str) -> Box:
    """Return a line of text with formulas between dollar signs."""
    parts = re.split(r"(?<!\\)\$", text)
    inline = Style(0, False)
    return joined(
        [setting(parse(x), inline) if k % 2 else words(x.replace("\\$", "$")) for k, x in enumerate(parts)]
    )


# -- scripts and accents -----------------------------------------------------------------------------------


def scripts(node: Scripts, style: Style) -> Box:
    """Return a node with its scripts (rule 18)."""
    base = setting(node.base, style)
    inside = style.script
    sub = None if node.sub is None else part(node.sub, style, inside)
    sup = None if node.sup is None else part(node.sup, style, inside)
    letter = is_name(node.base)
    up = (SUP_UP if base.height < 770 else SUP_UP + 60) if letter else max(SUP_UP, base.height - SUP_DROP)
    down = max(SUB_DOWN, 0 if letter and base.depth < 300 else base.depth + SUB_DROP)
    parts = [(base, 0.0, 0.0)]
    width = base.width
    if sup is not None:
        up = max(up, sup.depth + SUP_LEAST)
    if sub is not None:
        down = max(down, sub.height - SUB_MOST)
        if sup is not None:
            down = max(down, SUB_SUP_GAP + sub.height + sup.depth - up)
        parts.append((sub, base.width - base.lean, -down))
        width = max(width, base.width - base.lean + sub.width + 40)
    if sup is not None:
        parts.append((sup, base.width + 20, up))
        width = max(width, base.width + sup.width + 60)
    return overlaid(parts, width)


def accented(node: Accent, style: Style) -> Box:
    """Return a node with dots, a hat or a line above (rule 12)."""
    body = setting(node.body, style)
    if node.mark == "line":
        line = rule(body.width, BAR, body.height + 90)
        return overlaid([(body, 0, 0), (line, 0, 0)], body.width, body.lean)
    g = glyph("r", node.mark)
    box = letters(node.mark, "r")
    left, _, right, top = boxes.bounds(body)
    italic = isinstance(node.body, Symbol) and node.body.style in "ij"
    slant = 0.12 * min(top, 700) if italic else 0.0
    x = (left + right) / 2 + slant - (g.box[0] + g.box[2]) / 2
    up = max(0.0, top + 80 - g.box[1])
    return overlaid([(body, 0, 0), (box, x, up)], body.width, body.lean)


# -- fractions, roots, brackets ----------------------------------------------------------------------------


def fraction(node: Fraction, style: Style) -> Box:
    """Return a fraction (rule 15)."""
    top, below = (part(x, style, style.part) for x in (node.top, node.below))
    width = max(top.width - top.lean, below.width - below.lean) + 120
    gap = GAP[style.display]
    up = max(NUMERATOR_UP[style.display], AXIS + BAR / 2 + gap + top.depth)
    down = max(DENOMINATOR_DOWN[style.display], below.height + gap - AXIS + BAR / 2)
    places = [
        (top, (width - top.width + top.lean) / 2 + 40, up),
        (below, (width - below.width + below.lean) / 2 + 40, -down),
    ]
    return overlaid([*places, (rule(width, BAR, AXIS - BAR / 2), 40, 0)], width + 80)


def root(node: Root, style: Style) -> Box:
    """Return a root (rule 11): the sign as high as its body."""
    body = setting(node.body, style)
    gap = ROOT_GAP[style.display]
    height = max(body.height, X_HEIGHT) + body.depth + gap + BAR
    sign, sign_depth, sign_height = tall("√", height)
    extra = max(0.0, (sign_height - height) / 2)
    low = -body.depth - extra  # lower end of the sign
    line = low + sign_height - BAR
    g = boxes.bounds(sign)
    x = g[2]
    parts = [
        (sign, 0.0, low + sign_depth),
        (body, x + 30, 0.0),
        (rule(body.width + 60, BAR, line), x - 8, 0.0),
    ]
    start = 0.0
    if node.index is not None:
        index = part(node.index, style, Style(2, False))
        start = max(0.0, index.width - 0.55 * x)
        parts = [(b, px + start, py) for b, px, py in parts]
        parts.append((index, start + 0.55 * x - index.width, low + 0.6 * sign_height))
    return overlaid(parts, start + x + body.width + 80)


def tall(char: str, height: float) -> tuple[Box, float, float]:
    """Return a sign of at least a height, its depth and its height; beyond the largest of the fonts it is stretched."""
    for style in SIZES:
        if not has(style, char):
            continue
        g = glyph(style, char)
        size = g.box[3] - g.box[1]
        if size >= height:
            break
    k = max(1.0, height / size)
    item = boxes.Placed(g, 0, 0, 1, k)
    return Box(g.advance, g.box[3] * k, -g.box[1] * k, (item,)), -g.box[1] * k, size * k


def fences(node: Fenced, body: Box) -> tuple[Box, Box]:
    """Return the brackets of a node (rule 19)."""
    reach = max(body.height - AXIS, body.depth + AXIS)
    height = max(1.6 * reach, 2 * reach - 500)
    return fence(node.left, height), fence(node.right, height)


def fence(char: str, height: float) -> Box:
    """Return one bracket, its middle on the axis."""
    if char == " ":
        return EMPTY
    if char in "|‖":
        half = max(height, 900) / 2
        bar = rule(50, 2 * half, AXIS - half)
        lines = [(bar, 70.0, 0.0)] if char == "|" else [(bar, 70.0, 0.0), (bar, 210.0, 0.0)]
        return overlaid(lines, 190.0 if char == "|" else 330.0)
    sign, depth, size = tall(char, height)
    return raised(sign, AXIS - size / 2 + depth)


def grid(node: Grid, style: Style) -> Box:
    """Return rows of cells: a matrix, a column, cases."""
    inside = replace(style, display=node.name in ("aligned",))
    table = [[setting(cell, inside) for cell in row] for row in node.rows]
    count = max(map(len, table))
    widths = [max((row[j].width for row in table if j < len(row)), default=0) for j in range(count)]
    gap = 0 if node.name == "aligned" else 800
    height = [max([700, *(b.height for b in row)]) for row in table]
    depth = [max([250, *(b.depth for b in row)]) for row in table]
    total = sum(height) + sum(depth) + 200 * (len(table) - 1)
    y = AXIS + total / 2
    parts = []
    for row, h, d in zip(table, height, depth, strict=True):
        y -= h
        x = 0.0
        for j, box in enumerate(row):
            if node.name == "cases" or node.name == "aligned" and j % 2:
                place = x
            elif node.name == "aligned":
                place = x + widths[j] - box.width
            else:
                place = x + (widths[j] - box.width) / 2
            parts.append((box, place, y))
            x += widths[j] + gap
        y -= d + 200
    body = overlaid(parts, sum(widths) + gap * (count - 1))
    body = replace(body, height=AXIS + total / 2, depth=total / 2 - AXIS)
    brackets = GRIDS[node.name]
    fenced = fences(Fenced(brackets[0], node, brackets[1]), body)
    return joined([fenced[0], space(60), body, space(60), fenced[1]])
