// A body on the stage: its points, surface or lines, and the cut face of its tetrahedra.
import { BufferAttribute, BufferGeometry, Color, DoubleSide, Group, LineSegments, Mesh, Points, ShaderMaterial, Vector2 } from "three";
import { placed } from "./frame.js";
import { section } from "./section.js";
import { points, surface } from "./shaders.js";

const STROKE = [-1, 0, 1].flatMap((x) => [-1, 0, 1].map((y) => [x, y])); // copies of lines that are one pixel wide, shifted by a pixel, look like a wide line

export class Actor {
  constructor(body, frame, shared, flat) {
    this.body = body;
    this.frame = frame;
    this.positions = new Float32Array(3 * body.points);
    this.own = {
      plain: { value: plainColour(body.colour) },
      coloured: { value: 0 },
      lit: { value: flat || body.kind === "lines" ? 0 : 1 },
      radius: { value: body.radius / frame.size },
    };
    this.uniforms = { ...shared, ...this.own, whole: { value: 0 }, shift: { value: new Vector2() } };
    this.object = new Group();
    this.object.add(...this.drawn());
    if (body.tetrahedra.length) {
      const uniforms = { ...this.uniforms, whole: { value: 1 }, lit: { value: 0 } };
      this.face = new Mesh(new BufferGeometry(), new ShaderMaterial({ ...surface, uniforms, side: DoubleSide }));
      this.face.frustumCulled = false;
      this.object.add(this.face);
    }
  }

  drawn() {
    const { kind, vertex, triangles, lines } = this.body, geometry = (this.geometry = new BufferGeometry());
    this.corners = kind === "surface" ? vertex : null; // a point on a sharp edge has several vertices
    const count = this.corners ? vertex.length : this.body.points;
    geometry.setAttribute("position", new BufferAttribute(new Float32Array(3 * count), 3));
    geometry.setAttribute("shade", new BufferAttribute(new Uint8Array(count), 1, true));
    geometry.setAttribute("failed", new BufferAttribute(new Uint8Array(count), 1));
    if (kind !== "points") geometry.setIndex(new BufferAttribute(kind === "surface" ? triangles : lines, 1));
    const Kind = { points: Points, surface: Mesh, lines: LineSegments }[kind], copies = kind === "lines" ? STROKE : [[0, 0]];
    return copies.map((shift) => {
      const uniforms = { ...this.uniforms, shift: { value: new Vector2(...shift) } };
      const object = new Kind(geometry, new ShaderMaterial({ ...(kind === "points" ? points : surface), uniforms, side: DoubleSide }));
      object.frustumCulled = false;
      return object;
    });
  }

  show(instant, field, failures) {
    const { body, geometry, corners } = this, shades = body.shades.get(field)?.[instant];
    const failed = failures ? body.failures?.[instant] : null;
    placed(body, instant, this.frame, this.positions);
    const { position, shade, failed: marks } = geometry.attributes;
    for (let i = 0; i < position.count; i++) {
      const p = corners ? corners[i] : i;
      position.array.set(this.positions.subarray(3 * p, 3 * p + 3), 3 * i);
      shade.array[i] = shades ? shades[p] : 0;
      marks.array[i] = failed ? failed[p] : 0;
    }
    for (const attribute of [position, shade, marks]) attribute.needsUpdate = true;
    if (corners) geometry.computeVertexNormals();
    this.own.coloured.value = shades ? 1 : 0;
    Object.assign(this, { shades, failed });
  }

  cut(normal, offset) {
    if (!this.face) return;
    this.face.visible = Boolean(normal);
    if (!normal) return;
    const made = section(this.body.tetrahedra, this.positions, this.shades, this.failed, normal, offset);
    this.face.geometry.dispose();
    const geometry = (this.face.geometry = new BufferGeometry());
    geometry.setAttribute("position", new BufferAttribute(made.places, 3));
    geometry.setAttribute("shade", new BufferAttribute(made.shades, 1, true));
    geometry.setAttribute("failed", new BufferAttribute(made.failed, 1));
    geometry.setAttribute("normal", new BufferAttribute(new Float32Array(made.places.length), 3));
  }
}

function plainColour(text) {
  const parts = text.match(/\w\w/g).map((part) => parseInt(part, 16) / 255);
  return new Color().setRGB(...parts.map((part) => 0.3 + 0.62 * part));
}
