// Bundles src/main.js and the parts of three.js that it uses into the file that the package ships.
import { createHash } from "node:crypto";
import { copyFileSync, readFileSync, readdirSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { build } from "esbuild";

const here = dirname(fileURLToPath(import.meta.url));
const out = join(here, "../src/pellucid/results/view");
const sources = ["build.mjs", "package.json", ...readdirSync(join(here, "src")).sort().map((name) => `src/${name}`)];
const hash = createHash("sha256");
for (const name of sources) hash.update(readFileSync(join(here, name)));
const licence = join(here, "node_modules/three/LICENSE"), [owner] = readFileSync(licence, "utf-8").match(/Copyright.*/);
const { version } = JSON.parse(readFileSync(join(here, "node_modules/three/package.json")));

await build({
  entryPoints: [join(here, "src/main.js")],
  outfile: join(out, "view.js"),
  bundle: true,
  minify: true,
  format: "iife",
  target: "es2020",
  charset: "ascii",
  legalComments: "none",
  banner: { js: `/* With three.js ${version}, ${owner}, SPDX-License-Identifier: MIT. Built from viewer/, sources ${hash.digest("hex")} */` },
});
copyFileSync(licence, join(out, "LICENSE.three.txt"));
