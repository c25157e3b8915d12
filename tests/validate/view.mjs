// SPDX-License-Identifier: Apache-2.0
// node view.mjs MODULES WORLD PATH.csv WIDTHxHEIGHT BACKGROUND VIEWER OUT: a world in a browser, through every camera of
// a path, as OUT/0000.png and so on. VIEWER: three or cesium. MODULES: the folder whose node_modules hold the packages.
// WORLD: a folder, or the address of a server that is not this page's.
// Prints one line of JSON, what each picture shows; exit code 1 and what the page said when anything fails.
import { createServer } from "node:http";
import { createRequire } from "node:module";
import { mkdir, readFile } from "node:fs/promises";
import path from "node:path";
import { fileURLToPath } from "node:url";

const [modules, world, cameraPath, size, background, viewer, out] = process.argv.slice(2);
const require = createRequire(path.join(modules, "package.json"));
const puppeteer = require("puppeteer-core");
const [width, height] = size.split("x").map(Number);

const folders = {
  node_modules: path.join(modules, "node_modules"),
  page: path.dirname(fileURLToPath(import.meta.url)),
  world,
};
// What browsers insist on; the rest is bytes.
const types = {
  ".css": "text/css",
  ".html": "text/html",
  ".js": "text/javascript",
  ".json": "application/json",
  ".mjs": "text/javascript",
  ".wasm": "application/wasm",
};

async function answer(request, response) {
  const { pathname } = new URL(request.url, "http://localhost");
  const [folder, ...rest] = decodeURIComponent(pathname).slice(1).split("/");
  try {
    const body = await readFile(path.join(folders[folder], ...rest));
    response.writeHead(200, { "Content-Type": types[path.extname(pathname)] ?? "application/octet-stream" }).end(body);
  } catch {
    response.writeHead(404).end();
  }
}

async function cameras() {
  const [header, ...rows] = (await readFile(cameraPath, "utf8")).trim().split("\n");
  if (header !== "time_s,eye_x,eye_y,eye_z,target_x,target_y,target_z,fov_y_deg") throw new Error(`${cameraPath}: header`);
  return rows.map((row) => {
    const values = row.split(",").map(Number);
    return { eye: values.slice(1, 4), target: values.slice(4, 7), fov_y_deg: values[7] };
  });
}

const views = await cameras();
const server = createServer(answer);
await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
const origin = `http://127.0.0.1:${server.address().port}`;
const browser = await puppeteer.launch({
  executablePath: "/usr/bin/chromium",
  protocolTimeout: 0, // who started this says how long it may take
  defaultViewport: { width, height, deviceScaleFactor: 1 },
  // A sandbox wants rights that containers lack; the pages are our own. No service of the browser calls out.
  args: ["--no-sandbox", "--disable-dev-shm-usage", "--use-gl=angle", "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader", "--force-color-profile=srgb", "--disable-background-networking",
    "--disable-component-update", "--disable-sync", "--disable-quic", "--no-first-run"],
});
const faults = [];
try {
  const page = await browser.newPage();
  // CesiumJS decodes one mesh a frame and core less one.
  await (await page.createCDPSession()).send("Emulation.setHardwareConcurrencyOverride", { hardwareConcurrency: 32 });
  page.on("console", (message) => { if (message.type() === "error") faults.push(message.text()); });
  page.on("pageerror", (error) => faults.push(String(error)));
  page.on("requestfailed", (request) => faults.push(`${request.url()}: ${request.failure()?.errorText}`));
  page.on("response", (response) => { if (!response.ok()) faults.push(`${response.url()}: ${response.status()}`); });
  await page.goto(`${origin}/page/view.html`);
  await page.evaluate(async (name, color, tileset) => {
    window.show = await (await import(`/page/view_${name}.mjs`)).open(tileset, color);
  }, viewer, background, /^http:/.test(world) ? new URL("tileset.json", world).href : "/world/tileset.json");
  await mkdir(out, { recursive: true });
  const shown = [];
  for (const [i, view] of views.entries()) {
    shown.push(await page.evaluate((camera) => window.show(camera), view));
    await page.screenshot({ path: path.join(out, `${String(i).padStart(4, "0")}.png`) });
  }
  console.log(JSON.stringify(shown));
} catch (error) {
  faults.push(String(error));
} finally {
  await browser.close();
  server.close();
}
for (const fault of faults.slice(0, 20)) console.error(fault);
process.exit(faults.length > 0 ? 1 : 0);
