"""Draws hall.dxf, the press hall, as a drawing office would leave it: millimetres, layers, blocks.

python draw.py
"""

from pathlib import Path

import ezdxf
from ezdxf import units

FILE = Path(__file__).with_name("hall.dxf")
LAYERS = ("A-WALL", "A-BNDY", "S-COLS", "EQPM-PRESS", "EQPM-RACK", "A-FENCE", "A-TEXT")
PRESSES = {"P1": (7_000, 12_000), "P2": (15_000, 12_000), "P3": (23_000, 12_000)}


def rectangle(space, layer, x0, y0, x1, y1):
    corners = [(x0, y0), (x1, y0), (x1, y1), (x0, y1)]
    space.add_lwpolyline(corners, close=True, dxfattribs={"layer": layer})


def main():
    ezdxf.options.write_fixed_meta_data_for_testing = True  # the same bytes every time
    drawing = ezdxf.new("R2000", setup=False)
    drawing.units = units.MM
    for layer in LAYERS:
        drawing.layers.add(layer)
    space = drawing.modelspace()
    rectangle(space, "A-BNDY", 0, 0, 30_000, 18_000)
    # Walls as two lines, 300 apart, with an opening to the yard.
    for x0, x1 in ((0, 12_000), (16_000, 30_000)):
        rectangle(space, "A-WALL", x0, 0, x1, 300)
    rectangle(space, "A-WALL", 0, 17_700, 30_000, 18_000)
    for x in (0, 29_700):
        rectangle(space, "A-WALL", x, 300, x + 300, 17_700)
    for x in (11_000, 19_000):
        for y in (4_500, 15_500):
            space.add_circle((x, y), 250, dxfattribs={"layer": "S-COLS"})
    press = drawing.blocks.new("PRESS")
    rectangle(press, "0", -1_500, -1_250, 1_500, 1_250)  # its table stands on layer 0 of the block
    for name, at in PRESSES.items():
        space.add_blockref("PRESS", at, dxfattribs={"layer": "EQPM-PRESS"})
        space.add_text(name, height=300, dxfattribs={"layer": "A-TEXT", "insert": at})
    for k in range(2):
        rectangle(space, "EQPM-RACK", 2_000 + 4_500 * k, 1_200, 5_000 + 4_500 * k, 2_200)
    rectangle(space, "EQPM-RACK", 20_000, 15_500, 23_000, 16_500)
    space.add_line((26_000, 8_000), (26_000, 300), dxfattribs={"layer": "A-FENCE"})
    drawing.saveas(FILE)


if __name__ == "__main__":
    main()
