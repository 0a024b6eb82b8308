// Starts every view of the page: reads its data, creates its stage and its controls.
import { addControls } from "./controls.js";
import { read } from "./data.js";
import { Stage } from "./stage.js";

async function mount(place) {
  const [words, packed] = place.querySelectorAll("script");
  let stage;
  try {
    stage = new Stage(place, await read(JSON.parse(words.textContent), packed.textContent));
  } catch (error) {
    place.classList.add("failed");
    console.warn(`The interactive view could not start: ${error.message}`);
    return;
  }
  packed.remove();
  addControls(place, stage);
  place.classList.add("ready");
}

for (const place of document.querySelectorAll(".pellucid-view:not(.begun)")) {
  place.classList.add("begun");
  mount(place);
}
