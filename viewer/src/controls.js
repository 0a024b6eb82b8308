// Controls of the view: time, colours, cut plane and visible bodies.
import { LinearSRGBColorSpace } from "three";
import { addLegend } from "./legend.js";
import { element, prefixed } from "./words.js";

const LONGEST = 6000, SLOWEST = 200, QUICKEST = 40; // durations [ms]: of a film; of one frame, longest and shortest

export function addControls(place, stage) {
  const tell = addLegend(stage), change = (changes) => (stage.set(changes), tell());
  const rows = [instants(stage, change), element("div", { className: "row" }, ...colours(stage, change)), bodies(stage, change)];
  if (!stage.scene.flat) rows[1].append(...cut(stage));
  const hint = stage.scene.flat ? "Drag to pan" : "Drag to rotate; drag with two fingers or the right mouse button to pan";
  const notes = [...stage.scene.notes, ...(stage.scene.notes.length ? ["The result files contain all data"] : []), `${hint}`, "Click the picture, then turn the wheel to zoom", "Double-click to reset the view"];
  place.append(...rows, element("p", { className: "notes" }, `${notes.join(". ")}.`));
  tell();
}

function instants(stage, change) {
  const { times } = stage.scene, last = times.length - 1, time = element("output");
  const slider = element("input", { type: "range", className: "instant", min: 0, max: last, step: 1, value: stage.instant });
  const play = element("button", { type: "button", className: "play" });
  slider.setAttribute("aria-label", "time");
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
    play.setAttribute("aria-label", "pause");
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
  const { fields } = stage.scene, options = [...fields.map(({ word }, k) => [k, word]), [-1, "body"]];
  const [choice, label] = select("colour by", "field", options, stage.field);
  choice.onchange = () => change({ field: Number(choice.value) });
  return [label];
}

function cut(stage) {
  const { frame, scene } = stage, steps = 200;
  const towards = (axis) => (scene.axes[2][axis] < 0 ? -1 : 1); // the side towards the viewer is cut away first
  const [axis, label] = select("cut normal to", "axis", [[-1, "none"], [0, "x"], [1, "y"], [2, "z"]], scene.cut ? scene.cut[0] : -1);
  const slider = element("input", { type: "range", className: "cut", min: 0, max: steps, value: steps / 2 });
  const other = element("input", { type: "checkbox" }), side = element("label", {}, other, " keep the other side"), at = element("output");
  slider.setAttribute("aria-label", "position of the cut");
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
