"""Prints a file through Printrun's printcore: PORT BAUD FILE."""
import sys
import time

from printrun import gcoder
from printrun.printcore import printcore

port, baud, path = sys.argv[1], int(sys.argv[2]), sys.argv[3]
core = printcore()
core.loud = False
core.connect(port, baud)
deadline = time.monotonic() + 30
while not core.online:
    if time.monotonic() > deadline:
        sys.exit("printcore: not online")
    time.sleep(0.02)
with open(path) as file:
    core.startprint(gcoder.LightGCode([line.rstrip("\n") for line in file]))
while core.printing:
    time.sleep(0.05)
core.disconnect()
