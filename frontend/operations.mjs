// Part of `npm run types`: writes what each request needs of who sends it, and the limits of the fields of its body, from
// the OpenAPI document. With --check it writes nothing, and fails where a file is another one.
import { readFileSync, writeFileSync } from "node:fs";

const { paths, components } = JSON.parse(readFileSync("openapi.json", "utf8"));
const requests = Object.entries(paths)
  .flatMap(([path, operations]) =>
    Object.entries(operations).map(([method, operation]) => ({
      name: `${method.toUpperCase()} ${path}`,
      operation,
    })),
  )
  .sort((one, other) => (one.name < other.name ? -1 : 1));

const LIMITS = ["minimum", "maximum", "minLength", "maxLength", "maxItems"];

/** The limits of the fields of a schema, by their dotted paths; an element of a list is its field `[]`. */
function limitsIn(schema, path = "") {
  const { $ref, anyOf = [], oneOf = [], properties = {}, items } = schema;
  if ($ref !== undefined) return limitsIn(components.schemas[$ref.split("/").at(-1)], path);
  const own = LIMITS.flatMap((limit) => (limit in schema ? [`${limit}: ${schema[limit]}`] : []));
  const fields = Object.entries(properties).map(([name, field]) => [
    field,
    path === "" ? name : `${path}.${name}`,
  ]);
  const choices = [...anyOf, ...oneOf].map((each) => [each, path]);
  const inner = [...fields, ...choices, ...(items ? [[items, `${path}[]`]] : [])];
  return [
    ...(own.length === 0 ? [] : [`    "${path}": { ${own.join(", ")} },\n`]),
    ...inner.flatMap(([field, name]) => limitsIn(field, name)),
  ];
}

const roles = requests.flatMap(({ name, operation }) => {
  const { "x-role": role, "x-every-robot": everyRobot = false } = operation;
  const forAll = role === undefined || (role === "viewer" && !everyRobot);
  return forAll ? [] : `  "${name}": ["${role}", ${everyRobot}],\n`;
});
const LIMITED =
  /^(PUT \/(automation|shared-docks|webhooks)\/.*|PUT \/label|PUT \/goals\/{goal_id}\/tags|PUT \/session\/password|POST \/(session|tokens|missions|goals\/{goal_id}\/notes))$/;
const limits = requests.flatMap(({ name, operation }) => {
  const schema = operation.requestBody?.content["application/json"]?.schema;
  const lines = schema !== undefined && LIMITED.test(name) ? limitsIn(schema) : [];
  return lines.length === 0 ? [] : `  "${name}": {\n${lines.join("")}  },\n`;
});

const HEAD = "// Made from openapi.json by `npm run types`.\n\n";
const written = {
  "src/api/operations.gen.ts": `${HEAD}/** By request, but for those that every user may make: the least role, and whether it is about every robot. */
export const OPERATIONS = {
${roles.join("")}} as const;
`,
  "src/api/limits.gen.ts": `${HEAD}/** By request, of those that a form is for: the limits of the fields of its body. */
export const LIMITS = {
${limits.join("")}} as const;
`,
};

for (const [file, text] of Object.entries(written)) {
  if (!process.argv.includes("--check")) writeFileSync(file, text);
  else if (readFileSync(file, "utf8") !== text) {
    process.stderr.write(`${file} is not that of openapi.json: run npm run types.\n`);
    process.exitCode = 1;
  }
}
