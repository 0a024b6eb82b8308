// The picture: a camera with parallel projection, the bodies, and the cut plane.
import { DataTexture, LinearFilter, OrthographicCamera, RGBAFormat, Scene, Vector2, Vector3, Vector4, WebGLRenderer } from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { Actor } from "./actor.js";
import { frameOf } from "./frame.js";

const ROOM = 90; // total height above and below a plane problem for texts [pixels]
const MARGIN = 1.06, AWAY = 20, EVERYTHING = 1e9;

export class Stage {
  constructor(place, scene) {
    this.scene = scene;
    this.frame = frameOf(scene.window);
    this.renderer = new WebGLRenderer({ antialias: true, alpha: true });
    this.canvas = this.renderer.domElement;
    this.canvas.tabIndex = 0;
    this.canvas.setAttribute("role", "img");
    this.canvas.setAttribute("aria-label", `${scene.title}, interactive view`);
    this.box = document.createElement("div");
    this.box.className = "stage";
    this.box.append(this.canvas);
    place.prepend(this.box);
    this.shared = { palette: { value: null }, cut: { value: new Vector4(0, 0, 0, EVERYTHING) }, pixels: { value: 1 }, pixel: { value: new Vector2() }, depth: { value: 2 * AWAY } };
    this.drawn = new Scene();
    this.actors = scene.bodies.map((body) => new Actor(body, this.frame, this.shared, scene.flat));
    scene.bodies.forEach((body, k) => (this.actors[k].object.visible = !body.hidden));
    this.drawn.add(...this.actors.map((actor) => actor.object));
    this.textures = Object.fromEntries(Object.entries(scene.palettes).map(([name, bytes]) => [name, texture(bytes)]));
    this.camera = new OrthographicCamera(-1, 1, 1, -1, 0, 2 * AWAY);
    this.controls = new OrbitControls(this.camera, this.canvas);
    this.controls.enableRotate = !scene.flat;
    this.controls.enableZoom = false; // so that the wheel scrolls the page
    this.controls.screenSpacePanning = true;
    if (scene.flat) Object.assign(this.controls.mouseButtons, { LEFT: 2 }), Object.assign(this.controls.touches, { ONE: 1 });
    this.controls.addEventListener("change", () => this.ask());
    this.canvas.addEventListener("pointerdown", () => (this.controls.enableZoom = true));
    this.canvas.addEventListener("pointerleave", () => (this.controls.enableZoom = this.canvas.matches(":active")));
    this.canvas.addEventListener("dblclick", () => this.home());
    this.afterwards = [];
    Object.assign(this, { instant: scene.times.length - 1, field: scene.fields.length ? 0 : -1, failures: true, slice: null });
    this.home();
    new ResizeObserver(() => this.fit()).observe(this.box);
    this.fit();
    this.update();
  }

  // reset the camera
  home() {
    const [, up, eye] = this.scene.axes.map((axis) => new Vector3(...axis));
    this.camera.up.set(...(this.scene.flat ? up.toArray() : [0, 0, 1]));
    this.camera.zoom = 1;
    this.camera.position.copy(eye).multiplyScalar(AWAY);
    this.controls.target.set(0, 0, 0);
    this.fit();
    this.controls.update();
  }

  // fit the canvas to the page, and the picture to the canvas
  fit() {
    const width = this.box.clientWidth, [wide, tall] = [this.reach(0), this.reach(1)];
    const shape = this.scene.flat ? (width * tall) / wide + ROOM : Math.max(0.62 * width, Math.min(width, 320));
    const height = Math.round(Math.min(Math.max(shape, 180), 0.8 * window.innerHeight, 640));
    this.renderer.setPixelRatio(window.devicePixelRatio);
    this.renderer.setSize(width, height);
    const half = MARGIN * Math.max(this.scene.flat ? (tall * height) / (height - ROOM) : tall, (wide * height) / width);
    Object.assign(this.camera, { left: (-half * width) / height, right: (half * width) / height, top: half, bottom: -half });
    this.ask();
  }

  // extent of the bodies from the centre to the right (k = 0) or upwards (k = 1), including the radius of a ball
  reach(k) {
    return this.frame.reach[k] / this.frame.size + Math.max(...this.actors.map((actor) => actor.own.radius.value));
  }

  // size of a pixel of the page [m]
  get metres() {
    return ((this.camera.top - this.camera.bottom) / this.camera.zoom / this.canvas.clientHeight) * this.frame.size;
  }

  set(changes) {
    Object.assign(this, changes);
    this.update();
  }

  update() {
    const field = this.scene.fields[this.field];
    if (field) this.shared.palette.value = this.textures[field.palette];
    for (const actor of this.actors) if (actor.object.visible) actor.show(this.instant, this.field, this.failures);
    this.setCut();
  }

  // slice: { axis, at [m], sign }; material beyond the plane in the direction of the sign is cut away
  setCut() {
    const { slice, frame } = this, normal = slice && [0, 1, 2].map((k) => (k === slice.axis ? slice.sign : 0));
    const offset = slice && (slice.sign * (slice.at - frame.middle[slice.axis])) / frame.size;
    this.shared.cut.value.set(...(slice ? [...normal, offset] : [0, 0, 0, EVERYTHING]));
    for (const actor of this.actors) if (actor.object.visible) actor.cut(normal, offset);
    this.ask();
  }

  ask() {
    this.asked ??= requestAnimationFrame(() => {
      this.asked = null;
      this.camera.updateProjectionMatrix();
      const pixels = (this.canvas.height * this.camera.zoom) / (this.camera.top - this.camera.bottom);
      this.shared.pixels.value = pixels;
      this.shared.pixel.value.set(2 / this.canvas.width, 2 / this.canvas.height).multiplyScalar(window.devicePixelRatio);
      this.renderer.render(this.drawn, this.camera);
      for (const after of this.afterwards) after();
    });
  }
}

function texture(bytes) {
  const texels = new Uint8Array((bytes.length / 3) * 4).fill(255);
  for (let i = 0; i < bytes.length / 3; i++) texels.set(bytes.subarray(3 * i, 3 * i + 3), 4 * i);
  const made = new DataTexture(texels, bytes.length / 3, 1, RGBAFormat);
  Object.assign(made, { minFilter: LinearFilter, magFilter: LinearFilter, needsUpdate: true });
  return made;
}
