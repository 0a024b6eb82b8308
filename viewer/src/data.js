// Unpacks the arrays that packing.py wrote.
export const LEVELS = 8191, GONE = 65535, SHADES = 254;

const bytesOf = (text) => Uint8Array.from(atob(text.trim()), (letter) => letter.charCodeAt(0));

async function inflate(bytes) {
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

class Reader {
  constructor(bytes) {
    this.bytes = bytes;
    this.at = 0;
  }

  // read an array of this type, stored as differences from the array `before` or else from the previous number
  next(Kind, count, before) {
    const size = Kind.BYTES_PER_ELEMENT, found = new Kind(count), start = this.at;
    for (let i = 0, last = 0; i < count; i++) {
      let folded = 0;
      for (let k = 0; k < size; k++) folded |= this.bytes[start + k * count + i] << (8 * k);
      found[i] = (before ? before[i] : last) + ((folded >>> 1) ^ -(folded & 1));
      last = found[i];
    }
    this.at += size * count;
    return found;
  }

  series(Kind, count, instants) {
    const found = [];
    for (let k = 0; k < instants; k++) found.push(this.next(Kind, count, found[k - 1]));
    return found;
  }
}

export async function read(scene, text) {
  const reader = new Reader(await inflate(bytesOf(text))), instants = scene.times.length;
  for (const body of scene.bodies) {
    for (const [name, shape] of Object.entries(body.cells)) {
      const [rows, columns = 1] = shape, flat = reader.next(Uint32Array, rows * columns), cells = new Uint32Array(flat.length);
      for (let c = 0; c < columns; c++) for (let r = 0; r < rows; r++) cells[r * columns + c] = flat[c * rows + r];
      body[name] = cells;
    }
    body.places = reader.series(Uint16Array, 3 * body.points, instants);
    body.shades = new Map();
    for (const field of body.fields) body.shades.set(field, reader.series(Uint8Array, body.points, instants));
    body.failures = body.failed ? reader.series(Uint8Array, body.points, instants) : null;
  }
  for (const name in scene.palettes) scene.palettes[name] = bytesOf(scene.palettes[name]);
  return scene;
}
