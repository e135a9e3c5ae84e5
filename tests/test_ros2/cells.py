"""Trials that tests serve."""

HANG = 300.0
"""Seconds. What takes longer hangs, however busy the machine is."""

HALL = """
floorplan:
  name: hall
  boundary: [[0, 0], [20, 0], [20, 12], [0, 12]]
  safe_zone: {at: [2, 2]}
  stations: {press: [16, 10], dock: [4, 10]}
  obstacles: {rack: {x: [8, 12], y: [6, 7], z: [0, 1]}}
duration: %g
seed: 3
rules: observe
people: [{name: ann, at: [6, 4], personality: external}]
machines:
  bot: {kind: amr, at: [2, 6.5, 0], size: [1.0, 0.7], controller: external}
"""

GANTRY = """
floorplan: ariac2023
duration: 600
rules: observe
gantry: {controller: external}
people: [{name: ann, at: [-5, 4], personality: external}]
"""


COMPETITION = """
time_limit: 600
kitting_trays: {tray_ids: [2], slots: [3]}
parts:
  bins:
    bin6: [{type: pump, color: red, slots: [1]}]
challenges:
  - human: {behavior: helpful, time_condition: 500}
orders:
  - id: KIT
    type: kitting
    announcement: {time_condition: 0}
    priority: false
    kitting_task:
      agv_number: 4
      tray_id: 2
      destination: warehouse
      products: [{type: pump, color: red, quadrant: 1}]
"""


def hall(duration=600.0):
    """A hall with a rack, a person and a vehicle, which only a client moves."""
    return HALL % duration


def antagonist(duration):
    """A person with intentions, whom nobody commands."""
    person = "{name: ann, personality: antagonistic}"
    return f"floorplan: ariac2023\nduration: {duration}\npeople: [{person}]\n"
