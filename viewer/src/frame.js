// Lengths of the stage: the box of what is seen has its middle at 0 and a half diagonal of 1.
import { LEVELS } from "./data.js";

const FAR = 1e6;

export function frameOf({ low, high, reach }) {
  const middle = low.map((value, k) => (value + high[k]) / 2);
  return { low, high, reach, middle, size: Math.hypot(...high.map((value, k) => value - low[k])) / 2 || 1 };
}

// positions of a body at an instant; points that are gone are far away
export function placed(body, instant, frame, into) {
  const from = body.places[instant], n = body.points;
  for (let k = 0; k < 3; k++) {
    const offset = (body.low[k] - frame.middle[k]) / frame.size, step = body.span[k] / LEVELS / frame.size;
    for (let i = 0; i < n; i++) {
      const value = from[k * n + i];
      into[3 * i + k] = value > LEVELS ? FAR : offset + value * step;
    }
  }
  return into;
}
