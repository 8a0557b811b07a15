#!/usr/bin/env python3
"""A second set of records as other programs write them, by someone who had not seen how the first set is read.

usage: make.py DIR [--check]

Every file has its own record; truth.json states what a careful engineer would read from it. With --check, other
libraries read the files back.
"""

import json
import os
import sys

from controllers import controllers
from damaged import damaged
from excel import excel
from freestyle import freestyle
from hdf5 import hdf5
from long_heads import long_heads
from matlab import matlab
from ni import ni
from recorders import recorders
from refuse import refuse
from scopes import scopes
from tdms import tdms
from tools import tools
from check_back import check
from common import OUT, TRUTH, path

# The order decides the numbers of the signals.
for write in (
    excel,
    tools,
    ni,
    scopes,
    recorders,
    controllers,
    freestyle,
    long_heads,
    matlab,
    hdf5,
    tdms,
    refuse,
    damaged,
):
    write()

for q in list(os.listdir(OUT)):
    if q.endswith(".tdms_index"):
        os.remove(path(q))
names = [e["file"] for e in TRUTH]
assert len(set(names)) == len(names)
extra = set(os.listdir(OUT)) - set(names)
assert not extra, extra
with open(OUT + "/truth.json", "w") as fh:
    json.dump(TRUTH, fh, ensure_ascii=False, allow_nan=False, indent=None)

if "--check" in sys.argv:
    check()
