"""Prints a file through Printrun's printcore: PORT BAUD FILE."""
import resource
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
def cpu_use():
    usage = resource.getrusage(resource.RUSAGE_SELF)
    return usage.ru_utime, usage.ru_stime, usage.ru_nvcsw


with open(path) as file:
    lines = gcoder.LightGCode([line.rstrip("\n") for line in file])
before = cpu_use()
core.startprint(lines)
while core.printing:
    time.sleep(0.05)
took = [now - then for now, then in zip(cpu_use(), before)]
core.disconnect()
print(*took)
