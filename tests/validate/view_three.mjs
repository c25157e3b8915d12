// SPDX-License-Identifier: Apache-2.0
// A world in three.js by 3d-tiles-renderer. open(tileset): a function that draws a camera once all it sees is loaded.
import { Color, HemisphereLight, PerspectiveCamera, Scene, WebGLRenderer } from "three";
import { DRACOLoader } from "three/addons/loaders/DRACOLoader.js";
import { TilesRenderer } from "3d-tiles-renderer/three";
import { GLTFExtensionsPlugin } from "3d-tiles-renderer/three/plugins";

export function open(tileset, background) {
  const renderer = new WebGLRenderer({ antialias: false, logarithmicDepthBuffer: true });
  const [width, height] = [innerWidth, innerHeight];
  renderer.setSize(width, height);
  document.querySelector("#scene").append(renderer.domElement);

  const scene = new Scene();
  scene.background = new Color(background);
  const light = new HemisphereLight(0xffffff, 0x404040, 3);
  light.position.set(0.3, -0.4, 1);
  scene.add(light);

  const camera = new PerspectiveCamera(60, width / height, 0.05, 1e5);
  camera.up.set(0, 0, 1);
  const dracoLoader = new DRACOLoader().setDecoderPath("/node_modules/three/examples/jsm/libs/draco/gltf/");
  const tiles = new TilesRenderer(tileset);
  tiles.registerPlugin(new GLTFExtensionsPlugin({ dracoLoader }));
  tiles.setCamera(camera);
  tiles.setResolution(camera, width, height);
  tiles.errorTarget = 0; // the full detail of all that the camera sees, as the replay draws it
  scene.add(tiles.group);

  const failed = new Promise((_, reject) => {
    tiles.addEventListener("load-error", ({ url, error }) => reject(new Error(`${url}: ${error}`)));
  });
  const opened = new Promise((resolve) => tiles.addEventListener("load-root-tileset", resolve));

  async function show({ eye, target, fov_y_deg }) {
    camera.fov = fov_y_deg;
    camera.position.set(...eye);
    camera.lookAt(...target);
    camera.updateProjectionMatrix();
    camera.updateMatrixWorld();
    tiles.update();
    await opened;
    // A view loads in waves, children after parents. Two updates without work behind them: the first one asks for what
    // this camera lacks, the second one shows what has come.
    let idle = 0;
    while (idle < 2) {
      await new Promise(requestAnimationFrame);
      tiles.update();
      const { queued, downloading, parsing } = tiles.stats;
      idle = queued + downloading + parsing === 0 && !tiles.isLoading ? idle + 1 : 0;
    }
    renderer.render(scene, camera);
    return { tiles: tiles.stats.visible, triangles: renderer.info.render.triangles };
  }
  return (view) => Promise.race([show(view), failed]);
}
