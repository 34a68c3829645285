// Part of `npm run types`: writes what each request needs of who sends it, from the OpenAPI document. With --check it
// writes nothing, and fails where the file is another one.
import { readFileSync, writeFileSync } from "node:fs";

const TARGET = "src/api/operations.gen.ts";

const { paths } = JSON.parse(readFileSync("openapi.json", "utf8"));
const lines = Object.entries(paths).flatMap(([path, operations]) =>
  Object.entries(operations).flatMap(([method, operation]) => {
    const { "x-role": role, "x-every-robot": everyRobot = false } = operation;
    const name = `${method.toUpperCase()} ${path}`;
    return role === undefined ? [] : `  "${name}": { role: "${role}", everyRobot: ${everyRobot} },\n`;
  }),
);
const written = `// Made from openapi.json by \`npm run types\`.

/** By request: the least role that it needs, and whether it is about every robot. */
export const OPERATIONS = {
${lines.sort().join("")}} as const;
`;

if (!process.argv.includes("--check")) writeFileSync(TARGET, written);
else if (readFileSync(TARGET, "utf8") !== written) {
  process.stderr.write(`${TARGET} is not that of openapi.json: run npm run types.\n`);
  process.exitCode = 1;
}
