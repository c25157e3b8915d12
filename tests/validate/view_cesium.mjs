// SPDX-License-Identifier: Apache-2.0
// A world in CesiumJS without a globe. open(tileset): a function that draws a camera once all it sees is loaded.
window.CESIUM_BASE_URL = "/node_modules/cesium/Build/Cesium/";
const { Cartesian3, Cesium3DTileset, CesiumWidget, Color } = await import("cesium");

export async function open(url, background) {
  const widget = new CesiumWidget("scene", {
    creditContainer: document.createElement("div"), // nothing over the picture
    baseLayer: false,
    globe: false,
    skyBox: false,
    skyAtmosphere: false,
    useDefaultRenderLoop: false,
    msaaSamples: 1,
    contextOptions: { webgl: { antialias: false, preserveDrawingBuffer: true } },
  });
  const { scene } = widget;
  const { camera } = scene;
  scene.backgroundColor = Color.fromCssColorString(background);
  scene.fog.enabled = false;
  // The full detail of all that the camera sees, as the replay draws it.
  const tileset = await Cesium3DTileset.fromUrl(url, { maximumScreenSpaceError: 0, dynamicScreenSpaceError: false });
  scene.primitives.add(tileset);

  const failed = new Promise((_, reject) => {
    tileset.tileFailed.addEventListener(({ url, message }) => reject(new Error(`${url}: ${message}`)));
    scene.renderError.addEventListener((_, error) => reject(error));
  });

  const unit = (v) => Cartesian3.normalize(v, v);
  const aspect = innerWidth / innerHeight;
  camera.frustum.near = 0.05;
  async function show({ eye, target, fov_y_deg }) {
    camera.frustum.aspectRatio = aspect;
    camera.frustum.fov = 2 * Math.atan(Math.tan((fov_y_deg * Math.PI) / 360) * Math.max(aspect, 1)); // of the wider side
    const position = Cartesian3.fromArray(eye);
    const direction = unit(Cartesian3.subtract(Cartesian3.fromArray(target), position, new Cartesian3()));
    const right = unit(Cartesian3.cross(direction, Cartesian3.UNIT_Z, new Cartesian3()));
    const up = Cartesian3.cross(right, direction, new Cartesian3());
    camera.setView({ destination: position, orientation: { direction, up } });
    // Two frames without work behind them: the first one asks for what this camera lacks, the second one shows what has come.
    let idle = 0;
    while (idle < 2) {
      await new Promise(requestAnimationFrame);
      scene.render();
      idle = tileset.tilesLoaded ? idle + 1 : 0;
    }
    return { tiles: tileset.statistics.selected, triangles: tileset.statistics.numberOfTrianglesSelected };
  }
  return (view) => Promise.race([show(view), failed]);
}
