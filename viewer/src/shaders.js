// How points and surfaces look. Both show a shade of the palette, or their body's own colour, lit from the eye.
const colour = `
uniform sampler2D palette;
uniform vec3 plain;
uniform float coloured, lit;
varying float vShade, vFailed;
vec3 shown(vec3 normal) {
  vec3 base = plain;
  if (coloured > 0.5 && vShade < 1.002) base = texture2D(palette, vec2((vShade * 255.0 + 0.5) / 256.0, 0.5)).rgb;
  if (vFailed > 0.5) base = vec3(0.9, 0.1, 0.09);
  float towards = max(dot(normalize(normal), normalize(vec3(-0.25, 0.45, 1.0))), 0.0);
  return base * mix(1.0, 0.58 + 0.5 * towards, lit);
}`;

const given = `
attribute float shade, failed;
varying float vShade, vFailed;
varying vec3 vPlace;
void give() {
  vShade = shade * 255.0 / 254.0;
  vFailed = failed;
  vPlace = position;
}`;

const cut = `
uniform vec4 cut;
bool isCut(vec3 place) { return dot(cut.xyz, place) > cut.w; }`;

export const points = {
  vertexShader: `${given}${cut}
uniform float radius, pixels;
void main() {
  give();
  gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
  gl_PointSize = max(2.0 * radius * pixels, 2.0);
  if (isCut(position)) gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
}`,
  fragmentShader: `${colour}
uniform float radius, depth;
void main() {
  vec2 at = vec2(2.0, -2.0) * (gl_PointCoord - 0.5);
  float square = dot(at, at);
  if (square > 1.0) discard;
  float rise = sqrt(1.0 - square);
  gl_FragDepth = gl_FragCoord.z + radius * (2.0 - rise) / depth; // behind a membrane whose plane they reach through
  gl_FragColor = vec4(shown(vec3(at, rise)), 1.0);
}`,
};

export const surface = {
  vertexShader: `${given}
uniform vec2 shift, pixel;
varying vec3 vNormal;
void main() {
  give();
  vNormal = normalMatrix * normal;
  gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
  gl_Position.xy += shift * pixel;
}`,
  fragmentShader: `${colour}${cut}
uniform float whole;
varying vec3 vPlace, vNormal;
void main() {
  if (whole < 0.5 && isCut(vPlace) || dot(vPlace, vPlace) > 1e4) discard; // beyond: a corner is gone
  gl_FragColor = vec4(shown(gl_FrontFacing ? vNormal : -vNormal), 1.0);
}`,
};
