// The face that a plane leaves in tetrahedra.
const SIDES = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];

// Triangles in the plane normal . x = offset, three corners each, with the values interpolated.
export function section(tetrahedra, positions, shades, failures, normal, offset) {
  const places = [], values = [], failed = [];
  const beyond = (p) => normal[0] * positions[3 * p] + normal[1] * positions[3 * p + 1] + normal[2] * positions[3 * p + 2] - offset;
  const add = ([p, q, share]) => {
    for (let k = 0; k < 3; k++) places.push(positions[3 * p + k] + share * (positions[3 * q + k] - positions[3 * p + k]));
    values.push(shades ? shades[p] + share * (shades[q] - shades[p]) : 0);
    failed.push(failures && failures[share < 0.5 ? p : q] ? 1 : 0);
  };
  for (let t = 0; t < tetrahedra.length; t += 4) {
    const corners = [tetrahedra[t], tetrahedra[t + 1], tetrahedra[t + 2], tetrahedra[t + 3]], far = corners.map(beyond);
    const count = far.filter((distance) => distance > 0).length;
    if (count === 0 || count === 4) continue;
    let met = SIDES.filter(([a, b]) => far[a] > 0 !== far[b] > 0).map(([a, b]) => [corners[a], corners[b], far[a] / (far[a] - far[b])]);
    if (met.length === 4) met = [met[0], met[1], met[2], met[1], met[2], met[3]]; // opposite corners of the quadrilateral are 0 and 3
    met.forEach(add);
  }
  return { places: new Float32Array(places), shades: Uint8Array.from(values), failed: Uint8Array.from(failed) };
}
