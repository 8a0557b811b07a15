#!/usr/bin/env bash
# Tries the release in target/dist where there is no Rust: in a Debian of its own, as root, with debootstrap.
# The Python package and its dependencies come from a folder, so that nothing in there needs a network.
set -euo pipefail
cd "$(dirname "$0")/../../.."
dist=$PWD/target/dist
debian=${1:-target/debian}

if [[ ! -x $debian/usr/bin/python3 ]]; then
    debootstrap --variant=minbase --include=python3,python3-venv bookworm "$debian"
fi
rm -rf "$debian/tour"
mkdir -p "$debian/tour/wheels"
cp "$dist"/*manylinux*x86_64.whl "$debian/tour/wheels"
python3 -m pip download --quiet --dest "$debian/tour/wheels" --only-binary :all: --python-version 3.11 'numpy>=1.24' 'pandas>=2.0'
tar --extract --gzip --file "$dist"/piezoid-*-x86_64-unknown-linux-musl.tar.gz --directory "$debian/tour" --strip-components 1
tar --extract --gzip --file "$dist"/piezoid-*-page.tar.gz --directory "$debian/tour"
grep '^piezoid ' README.md >"$debian/tour/commands"
sed -n '/^```python$/,/^```$/p' docs/first-hour.md | grep -v '^```' >"$debian/tour/tour.py"

chroot "$debian" bash -euo pipefail <<'TOUR'
cd /tour
! command -v cargo
export PATH=/tour:$PATH
mkdir work && cd work
while read -r line; do echo "$ $line"; eval "$line" </dev/null; done <../commands
python3 -m venv ../python
../python/bin/pip install --quiet --no-index --find-links ../wheels piezoid
../python/bin/python ../tour.py
ls -l ../piezoid ../wheels
TOUR
