#!/usr/bin/env bash
# Tries the release in target/dist where there is no Rust: in a Debian of its own, as root, with debootstrap. The page is
# served from there by Python, and tried from here, with Node.js and Chromium. The container is built by buildah.
# The Python package and its dependencies come from a folder, so that nothing in there needs a network.
set -euo pipefail
cd "$(dirname "$0")/../../.."
dist=$PWD/target/dist
debian=$(realpath --canonicalize-missing "${1:-target/debian}")

if [[ ! -x $debian/usr/bin/python3 ]]; then
    debootstrap --variant=minbase --include=python3,python3-venv bookworm "$debian"
fi
rm -rf "$debian/tour"
mkdir -p "$debian/tour/wheels"
cp "$dist"/*manylinux*x86_64.whl "$debian/tour/wheels"
python3 -m pip download --quiet --dest "$debian/tour/wheels" --only-binary :all: --python-version 3.11 'numpy>=1.24' 'pandas>=2.0'
tar --extract --gzip --file "$dist"/piezoid-*-x86_64-unknown-linux-musl.tar.gz --directory "$debian/tour" --strip-components 1
for archive in page examples; do tar --extract --gzip --file "$dist"/piezoid-*-$archive.tar.gz --directory "$debian/tour"; done

chroot "$debian" bash -euo pipefail <<'TOUR'
cd /tour
! command -v cargo
export PATH=/tour:$PATH
mkdir work && cd work
examples=$(echo ../piezoid-*-examples)
while read -r line; do echo "$ $line"; eval "$line" </dev/null; done <"$examples/commands.txt"
# The library in an FMU is that of the compiler at hand.
diff --recursive --brief --exclude '*.fmu' --exclude commands.txt --exclude tour.py . "$examples"
python3 -m venv ../python
../python/bin/pip install --quiet --no-index --find-links ../wheels piezoid
../python/bin/python "$examples/tour.py"
ls -l ../piezoid ../wheels
TOUR

page=$(basename "$debian"/tour/piezoid-*-page)
chroot "$debian" python3 -m http.server --bind 127.0.0.1 --directory "/tour/$page" 8087 2>/dev/null &
trap 'kill %1' EXIT
PIEZOID_PAGE=http://127.0.0.1:8087/ node --test --test-reporter spec web/tests/page.test.mjs

scratch=$(mktemp -d)
trap 'kill %1; rm -r "$scratch"' EXIT
image() { buildah --storage-driver vfs --root "$scratch/images" --runroot "$scratch/run" "$@"; }
cp Containerfile "$dist"/piezoid-*-x86_64-unknown-linux-musl.tar.gz "$scratch"
version=$(basename "$scratch"/piezoid-*-x86_64-unknown-linux-musl.tar.gz -x86_64-unknown-linux-musl.tar.gz)
image build --isolation chroot --build-arg "VERSION=${version#piezoid-}" --tag piezoid "$scratch"
container=$(image from --pull-never localhost/piezoid)
image run --isolation chroot --volume "$debian/tour/work:/work" "$container" -- /piezoid validate stairs.csv --model model.json
image images
