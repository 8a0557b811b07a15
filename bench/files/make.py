"""Write all foreign files and truth.json into one directory.

Usage: python3 make.py DIR

Needs numpy and scipy. With h5py, npTDMS, pandas, pyarrow, asammdf, openpyxl,
hdf5storage and Pillow the set is complete. Equal package versions give equal
bytes. truth.json: one entry a file; see README.md.
"""
import importlib
import os
import sys

from common import Book

MODULES = ("csv_files", "csv_heads", "scopes", "scopes2", "loggers",
           "vendors", "matlab_files", "numpy_files", "tdms_files",
           "hdf5_files", "others")


def main(folder):
    os.makedirs(folder, exist_ok=True)
    book = Book(folder)
    for name in MODULES:
        try:
            module = importlib.import_module(name)
        except ImportError as e:
            print("left out: module %s (%s)" % (name, e))
            continue
        start = len(book.truth)
        module.make(book)
        for entry in book.truth[start:]:
            entry["family"] = name
    book.save()
    print("%d files" % len(book.truth))


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(sys.argv[1])
