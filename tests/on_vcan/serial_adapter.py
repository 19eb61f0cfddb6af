"""A serial CAN adapter that is not there, for the kernel's real slcan driver.

A pseudo terminal gets the driver's line discipline. The interface's name comes
out first, on a line. Then standard input goes to the driver as the adapter's
words, and what the driver says comes out.
"""

import fcntl
import os
import select
import struct
import sys
import termios
import tty

N_SLCAN = 17
SIOCGIFNAME = 0x8910

adapter, driver = os.openpty()
tty.setraw(driver)
fcntl.ioctl(driver, termios.TIOCSETD, struct.pack("i", N_SLCAN))
name = fcntl.ioctl(driver, SIOCGIFNAME, bytes(16)).rstrip(b"\0")
os.write(1, name + b"\n")

while True:
    for source in select.select([0, adapter], [], [])[0]:
        said = os.read(source, 4096)
        if not said:
            sys.exit()
        os.write(adapter if source == 0 else 1, said)
