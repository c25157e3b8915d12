// SPDX-License-Identifier: Apache-2.0
// node validate.mjs MODULES WORLD: every GLB of a world through the Khronos validator, and the geometry of each against
// its tile's volume and that of its parent, as another decoder sees it. Prints one line of JSON; exit code 1 and a line
// for each fault otherwise. MODULES: the folder whose node_modules hold the packages.
import { createRequire } from "node:module";
import { readFile, readdir } from "node:fs/promises";
import path from "node:path";

const [modules, world] = process.argv.slice(2);
const require = createRequire(path.join(modules, "package.json"));
const validator = require("gltf-validator");
const { NodeIO, getBounds } = require("@gltf-transform/core");
const { ALL_EXTENSIONS } = require("@gltf-transform/extensions");
const draco3d = require("draco3dgltf");

// Roundings of the decoders and of the decimal text.
const TOLERANCE_M = 2e-3;
const faults = [];
const totals = { glbs: 0, errors: 0, warnings: 0, tiles: 0, triangles: 0 };

async function filesOf(folder) {
  const found = [];
  for (const entry of await readdir(folder, { withFileTypes: true })) {
    const name = path.join(folder, entry.name);
    if (entry.isDirectory()) found.push(...(await filesOf(name)));
    else if (entry.name.endsWith(".glb")) found.push(name);
  }
  return found.sort();
}

for (const file of await filesOf(world)) {
  const report = await validator.validateBytes(new Uint8Array(await readFile(file)), { uri: file, maxIssues: 10 });
  totals.glbs += 1;
  totals.errors += report.issues.numErrors;
  totals.warnings += report.issues.numWarnings;
  for (const issue of report.issues.messages)
    if (issue.severity <= 1) faults.push(`${file}: ${issue.code} ${issue.pointer ?? ""}: ${issue.message}`);
}

const io = new NodeIO()
  .registerExtensions(ALL_EXTENSIONS)
  .registerDependencies({ "draco3d.decoder": await draco3d.createDecoderModule() });

// An axis-aligned box of 3D Tiles as minimum and maximum.
function extent(volume, where) {
  const b = volume.box;
  if (b === undefined || [4, 5, 6, 8, 9, 10].some((i) => b[i] !== 0)) throw new Error(`${where}: no upright box`);
  const half = [b[3], b[7], b[11]];
  return { min: half.map((h, i) => b[i] - h), max: half.map((h, i) => b[i] + h) };
}

function outside(inner, outer) {
  return Math.max(...[0, 1, 2].map((i) => Math.max(outer.min[i] - inner.min[i], inner.max[i] - outer.max[i])));
}

async function visit(tile, parent) {
  const where = tile.content?.uri ?? "a tile without content";
  totals.tiles += 1;
  if (parent !== null && tile.transform !== undefined) throw new Error(`${where}: a transform below the root`);
  const box = extent(tile.boundingVolume, where);
  if (parent !== null && outside(box, parent) > TOLERANCE_M)
    faults.push(`${where}: its volume leaves its parent's by ${outside(box, parent)} m`);
  if (tile.content !== undefined) {
    const document = await io.read(path.join(world, tile.content.uri));
    const root = document.getRoot();
    const y = getBounds(root.listScenes()[0]);
    // glTF's y is up: x stays, z is y, and y is -z.
    const seen = { min: [y.min[0], -y.max[2], y.min[1]], max: [y.max[0], -y.min[2], y.max[1]] };
    if (!(outside(seen, box) <= TOLERANCE_M))
      faults.push(`${where}: its geometry leaves its volume by ${outside(seen, box)} m`);
    for (const mesh of root.listMeshes())
      for (const primitive of mesh.listPrimitives()) totals.triangles += primitive.getIndices().getCount() / 3;
  }
  for (const child of tile.children ?? []) {
    if (child.geometricError > tile.geometricError) faults.push(`${where}: a smaller error than a child's`);
    await visit(child, box);
  }
}

const tileset = JSON.parse(await readFile(path.join(world, "tileset.json"), "utf8"));
await visit(tileset.root, null);

if (faults.length > 0) {
  for (const fault of faults.slice(0, 20)) console.error(fault);
  console.error(`faults: ${faults.length}`);
  process.exit(1);
}
console.log(JSON.stringify(totals));
