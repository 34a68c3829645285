// Run the scenario in Node.js: node run.mjs <folder with node_modules> <url>

import { createRequire } from "node:module";
import { pathToFileURL } from "node:url";
import { scenario } from "./scenario.mjs";

const [folder, url] = process.argv.slice(2);
const require = createRequire(`${folder}/package.json`);
const old = require(`${folder}/node_modules/roslib/package.json`).version.startsWith("1.");
const roslib = old
  ? require("roslib")
  : await import(pathToFileURL(`${folder}/node_modules/roslib/dist/RosLib.js`));
console.log(JSON.stringify(await scenario(roslib, url)));
process.exit(0);
