// Legend of the colours and scale bar.
import { element, number, prefixed, round } from "./words.js";

const WIDEST = 0.22, ROOM = 110; // largest width of the scale bar as a share of the window; smallest width for its text [pixels]

export function addLegend(stage) {
  const legend = element("div", { className: "legend" }), bar = element("div", { className: "bar" });
  stage.box.append(legend, bar);
  stage.afterwards.push(() => {
    const length = round(Math.max(WIDEST * stage.canvas.clientWidth, ROOM) * stage.metres);
    bar.style.width = `${length / stage.metres}px`;
    bar.textContent = prefixed(length, "m");
  });
  return () => {
    const field = stage.scene.fields[stage.field];
    legend.replaceChildren(...(field ? scale(stage.scene, field) : []), ...failures(stage));
  };
}

function scale(scene, field) {
  const bytes = scene.palettes[field.palette], stops = [];
  for (let i = 0; i < bytes.length; i += 3 * 15) stops.push(`rgb(${bytes[i]} ${bytes[i + 1]} ${bytes[i + 2]})`);
  const strip = element("div", { className: "strip" });
  strip.style.background = `linear-gradient(to right, ${stops})`;
  const below = field.least < field.low, above = field.most > field.high;
  strip.classList.toggle("below", below);
  strip.classList.toggle("above", above);
  const middle = (field.low + field.high) / 2;
  const ends = [field.low, middle, field.high].map((value) => element("span", {}, number(value)));
  const parts = [element("div", {}, field.word, field.unit ? ` [${field.unit}]` : ""), strip, element("div", { className: "ends" }, ...ends)];
  if (below || above) {
    const words = [below ? `down to ${number(field.least)}` : "", above ? `up to ${number(field.most)}` : ""].filter(Boolean);
    parts.push(element("div", { className: "beyond" }, `some points outside the scale: ${words.join(", ")}`));
  }
  return parts;
}

function failures(stage) {
  if (!stage.failures) return [];
  const count = stage.scene.bodies.reduce((sum, body, k) => {
    const failed = stage.actors[k].object.visible && body.failures?.[stage.instant];
    return sum + (failed ? failed.reduce((total, one) => total + one, 0) : 0);
  }, 0);
  return count ? [element("div", { className: "failures" }, `${count} failed points`)] : [];
}
