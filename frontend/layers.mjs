// Part of `npm run lint`: a folder of src imports only from itself and from folders that are listed before it. So no two
// folders import each other, and nothing that others build on knows what is built on it. The client is a package of its own:
// it imports only itself and its dependencies.
import { readdirSync, readFileSync } from "node:fs";
import { dirname, join, relative, sep } from "node:path";
import ts from "typescript";

const LAYERS = [
  // Transport: time, requests, events, and the state that they add up to.
  ...["clock", "api", "stream", "store"],
  // Components that know no robot.
  "ui",
  // What features share: all robots, who uses the page, one goal in words.
  ...["fleet", "access", "goal", "stop", "alerts", "approvals"],
  // Features.
  ...["battery", "docking", "scene", "cameras", "simulator", "automation", "actions", "goals", "operations"],
  ...["statistics", "audit", "notifications", "graph", "sites"],
  // What puts features together.
  ...["pages/robot", "pages/overview", "pages/map", "pages/wall", "pages", "search", "layout"],
];

/** The layer of a file, as a place in the list: the innermost of its folders that is there; -1 for none. */
function layerOf(file) {
  const folder = dirname(file).split(sep).join("/");
  const name = LAYERS.find((each) => folder === each || folder.startsWith(`${each}/`));
  return LAYERS.indexOf(name);
}

const problems = [];
for (const file of readdirSync("src", { recursive: true })) {
  if (!/\.tsx?$/.test(file) || dirname(file) === ".") continue; // main.tsx starts everything
  const layer = layerOf(file);
  if (layer < 0) problems.push(`src/${file}: its folder is in no layer of layers.mjs.`);
  for (const { fileName } of ts.preProcessFile(readFileSync(join("src", file), "utf8")).importedFiles) {
    if (!fileName.startsWith(".")) continue;
    const imported = relative("src", join("src", dirname(file), fileName));
    if (layerOf(imported) > layer)
      problems.push(`src/${file} imports ${imported}: layers.mjs lists ${LAYERS[layer]} before it.`);
  }
}

const { dependencies } = JSON.parse(readFileSync("client/package.json", "utf8"));
for (const file of readdirSync("client/src", { recursive: true })) {
  for (const { fileName } of ts.preProcessFile(readFileSync(join("client/src", file), "utf8"))
    .importedFiles) {
    const own = fileName.startsWith("./");
    const declared = Object.keys(dependencies).some((name) => `${fileName}/`.startsWith(`${name}/`));
    if (!own && !declared)
      problems.push(`client/src/${file} imports ${fileName}: it is no dependency in client/package.json.`);
  }
}
process.stderr.write(problems.map((problem) => `${problem}\n`).join(""));
process.exitCode = problems.length > 0 ? 1 : 0;
