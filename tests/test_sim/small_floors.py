"""Parts of small floors, and trials on such floors, for tests."""

import sim

GANTRY = """\
gantry:
  x: {range: [1, 19], max_speed: 1.0, max_acceleration: 0.5}
  y: {range: [1, 11], max_speed: 1.0, max_acceleration: 0.5}
  start: [10, 8, 0]
  torso: {size: [1.0, 1.0], z: [1.2, 1.6]}
  arm: {mount: [0.5, 0.0], reach: 0.9, bottom: 1.0}
  rail_height: 2.9
  tray_height: 1.3
"""
LANE = """\
agvs:
  size: [1.2, 0.8]
  height: 1.0
  max_speed: 1.0
  max_acceleration: 0.5
  limits: [0, 16]
  locations: {west: 0, middle: 8, east: 16}
  start: west
  lanes: {cart: {origin: [2, 2.75]}}
"""
HALL = """\
name: hall
boundary: [[0, 0], [20, 0], [20, 12], [0, 12]]
safe_zone: {at: [2, 2]}
stations: {press: [16, 10], dock: [4, 10]}
obstacles: {rack: {x: [8, 12], y: [6, 7], z: [0, 1]}}
"""
WORKCELL = HALL + GANTRY + LANE.replace("2.75", "1.2")
"""The hall with a gantry, and with a lane south of its rack."""


def on_floor(floor, text):
    """Return the text of a trial that contains its floor."""
    return "floorplan:\n" + "".join(f"  {line}\n" for line in floor.splitlines()) + text


def run_on(floor, text, folder):
    """Run a trial on a floor, after writing and reading the trial again."""
    trial = sim.Trial.parse(on_floor(floor, text), folder=folder)
    assert sim.Trial.parse(trial.to_yaml(folder), folder=folder) == trial
    return sim.run(trial)
