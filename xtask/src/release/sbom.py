"""Writes the bill of materials of a release (CycloneDX): the crates of the program and of the Python package for these
targets, and the packages in the page's script.

sbom.py VERSION SECONDS_SINCE_1970 BOM TRIPLE..."""

import json
import subprocess
import sys
import tomllib
import uuid
from datetime import UTC, datetime
from pathlib import Path

from cyclonedx.contrib.license.factories import LicenseFactory
from cyclonedx.model import HashAlgorithm, HashType
from cyclonedx.model.bom import Bom
from cyclonedx.model.component import Component, ComponentType
from cyclonedx.output.json import JsonV1Dot6
from packageurl import PackageURL

version, epoch, written, *triples = sys.argv[1:]
licences = LicenseFactory()
checksums = {
    (crate["name"], crate["version"]): crate["checksum"]
    for crate in tomllib.loads(Path("Cargo.lock").read_text())["package"]
    if "checksum" in crate
}


def crates():
    """Name, version and licence of each crate that is linked."""
    for triple in triples:
        tree = ["cargo", "tree", "--locked", "--edges", "normal", "--target", triple, "--prefix", "none"]
        tree += ["--package", "piezoid-cli", "--package", "piezoid-py", "--format", "{p}\t{l}"]
        for line in subprocess.run(tree, check=True, capture_output=True, text=True).stdout.splitlines():
            if line:
                package, licence = line.split("\t")
                name, version = package.split()[:2]
                yield name, version.removeprefix("v"), licence.removesuffix(" (*)")


def component(kind, name, version, licence, checksum=None):
    where = PackageURL(kind, None, name, version)
    hashes = [HashType(alg=HashAlgorithm.SHA_256, content=checksum)] if checksum else []
    return Component(
        name=name,
        version=version,
        type=ComponentType.LIBRARY,
        purl=where,
        bom_ref=str(where),
        hashes=hashes,
        licenses=[licences.make_from_string(licence.replace("/", " OR "))],
    )


bom = Bom(
    serial_number=uuid.uuid5(uuid.NAMESPACE_URL, f"piezoid {version} {epoch}"),
    components=[
        component("cargo", name, of, licence, checksums.get((name, of))) for name, of, licence in sorted(set(crates()))
    ],
)
bundled = json.loads(Path("web/package-lock.json").read_text())["packages"]
for name in ("fflate", "preact"):
    package = bundled[f"node_modules/{name}"]
    bom.components.add(component("npm", name, package["version"], package["license"]))
bom.metadata.component = Component(name="piezoid", version=version, type=ComponentType.APPLICATION, bom_ref="piezoid")
bom.register_dependency(bom.metadata.component, bom.components)
bom.metadata.timestamp = datetime.fromtimestamp(int(epoch), UTC)
Path(written).write_text(JsonV1Dot6(bom).output_as_string(indent=1) + "\n")
