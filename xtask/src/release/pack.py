"""Packs a folder into an archive, .tar.gz or .zip: sorted, of one time, without an owner, so that the same files give
the same bytes.

pack.py FOLDER ARCHIVE SECONDS_SINCE_1970"""

import gzip
import sys
import tarfile
import time
import zipfile
from pathlib import Path

folder, archive, epoch = Path(sys.argv[1]), Path(sys.argv[2]), int(sys.argv[3])
files = sorted(path for path in folder.rglob("*") if path.is_file())
names = [f"{folder.name}/{path.relative_to(folder).as_posix()}" for path in files]
modes = [0o755 if path.stat().st_mode & 0o100 else 0o644 for path in files]

if archive.suffix == ".zip":
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as into:
        for path, name, mode in zip(files, names, modes, strict=True):
            entry = zipfile.ZipInfo(name, time.gmtime(epoch)[:6])
            entry.external_attr, entry.compress_type = (0o100000 | mode) << 16, zipfile.ZIP_DEFLATED
            into.writestr(entry, path.read_bytes())
else:
    with (
        archive.open("wb") as raw,
        gzip.GzipFile("", "wb", 9, raw, mtime=epoch) as packed,
        tarfile.open(fileobj=packed, mode="w", format=tarfile.PAX_FORMAT) as into,
    ):
        for path, name, mode in zip(files, names, modes, strict=True):
            entry = tarfile.TarInfo(name)
            entry.size, entry.mtime, entry.mode = path.stat().st_size, epoch, mode
            with path.open("rb") as content:
                into.addfile(entry, content)
