// Instants, colours, cuts and bodies to choose.
import { LinearSRGBColorSpace } from "three";
import { addLegend } from "./legend.js";
import { element, prefixed } from "./words.js";

const LONGEST = 6000, SLOWEST = 200, QUICKEST = 40; // ms: of a film, of an instant in it

export function addControls(place, stage) {
  const tell = addLegend(stage), change = (changes) => (stage.set(changes), tell());
  const rows = [instants(stage, change), element("div", { className: "row" }, ...colours(stage, change)), bodies(stage, change)];
  if (!stage.scene.flat) rows[1].append(...cut(stage));
  const hint = stage.scene.flat ? "Drag to move" : "Drag to turn, with two fingers or the right button to move";
  const notes = [...stage.scene.notes, ...(stage.scene.notes.length ? ["The files have all"] : []), `${hint}; after a click the wheel zooms; a double click brings the first view back`];
  place.append(...rows, element("p", { className: "notes" }, `${notes.join(". ")}.`));
  tell();
}

function instants(stage, change) {
  const { times } = stage.scene, last = times.length - 1, time = element("output");
  const slider = element("input", { type: "range", className: "instant", min: 0, max: last, step: 1, value: stage.instant });
  const play = element("button", { type: "button", className: "play" });
  slider.setAttribute("aria-label", "instant");
  let timer = null;
  const show = (instant) => {
    slider.value = instant;
    time.textContent = `t = ${prefixed(times[instant], "s")}`;
    if (instant !== stage.instant) change({ instant });
  };
  const halt = () => {
    clearInterval(timer);
    timer = null;
    play.textContent = "▶";
    play.setAttribute("aria-label", "play");
  };
  const start = () => {
    const pause = Math.max(QUICKEST, Math.min(SLOWEST, LONGEST / times.length));
    timer = setInterval(() => show((stage.instant + 1) % times.length), pause);
    play.textContent = "❚❚";
    play.setAttribute("aria-label", "halt");
  };
  play.onclick = () => (timer ? halt() : start());
  slider.oninput = () => (halt(), show(Number(slider.value)));
  halt();
  show(stage.instant);
  return element("div", { className: "row", hidden: last === 0 }, play, slider, time);
}

function select(label, className, options, chosen) {
  const made = element("select", { className }, ...options.map(([value, word]) => element("option", { value }, word)));
  made.value = chosen;
  return [made, element("label", {}, `${label} `, made)];
}

function colours(stage, change) {
  const { fields } = stage.scene, options = [...fields.map(({ word }, k) => [k, word]), [-1, "bodies"]];
  const [choice, label] = select("colours", "field", options, stage.field);
  choice.onchange = () => change({ field: Number(choice.value) });
  return [label];
}

function cut(stage) {
  const { frame, scene } = stage, steps = 200;
  const towards = (axis) => (scene.axes[2][axis] < 0 ? -1 : 1); // the side of the eye goes first
  const [axis, label] = select("cut across", "axis", [[-1, "nothing"], [0, "x"], [1, "y"], [2, "z"]], scene.cut ? scene.cut[0] : -1);
  const slider = element("input", { type: "range", className: "cut", min: 0, max: steps, value: steps / 2 });
  const other = element("input", { type: "checkbox" }), side = element("label", {}, other, " other side"), at = element("output");
  slider.setAttribute("aria-label", "place of the cut");
  if (scene.cut) {
    const [k, place] = scene.cut;
    slider.value = ((place - frame.low[k]) / (frame.high[k] - frame.low[k])) * steps;
  }
  const apply = (place) => {
    const k = Number(axis.value), on = k >= 0;
    for (const part of [slider, side, at]) part.hidden = !on;
    const found = on ? place ?? frame.low[k] + (slider.value / steps) * (frame.high[k] - frame.low[k]) : 0;
    at.textContent = on ? `${"xyz"[k]} = ${prefixed(found, "m", 3)}` : "";
    stage.slice = on ? { axis: k, at: found, sign: towards(k) * (other.checked ? -1 : 1) } : null;
    stage.setCut();
  };
  axis.onchange = () => ((slider.value = steps / 2), apply());
  slider.oninput = other.onchange = () => apply();
  apply(scene.cut?.[1]);
  return [label, slider, at, side];
}

function bodies(stage, change) {
  const items = stage.scene.bodies.map((body, k) => {
    const box = element("input", { type: "checkbox", checked: !body.hidden });
    box.onchange = () => ((stage.actors[k].object.visible = box.checked), change({}));
    const swatch = element("span", { className: "swatch" });
    swatch.style.background = `#${stage.actors[k].own.plain.value.getHexString(LinearSRGBColorSpace)}`;
    return element("label", {}, box, swatch, body.name);
  });
  if (stage.scene.bodies.some((body) => body.failed)) {
    const box = element("input", { type: "checkbox", checked: true });
    box.onchange = () => change({ failures: box.checked });
    items.push(element("label", {}, box, element("span", { className: "swatch failed" }), "failed points"));
  }
  return element("div", { className: "row bodies" }, ...items);
}
