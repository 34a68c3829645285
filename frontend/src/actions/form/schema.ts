export type Json = null | boolean | number | string | readonly Json[] | JsonObject;

export interface JsonObject {
  readonly [name: string]: Json;
}

/** JSON Schema, as far as `/interfaces` makes use of it. */
export interface Schema {
  type?: string | readonly string[];
  $ref?: string;
  $defs?: Record<string, Schema>;
  anyOf?: readonly Schema[];
  properties?: Record<string, Schema>;
  items?: Schema;
  const?: Json;
  enum?: readonly Json[];
  default?: Json;
  title?: string;
  description?: string;
  format?: string;
  minimum?: number;
  maximum?: number;
  maxLength?: number;
  minItems?: number;
  maxItems?: number;
  contentEncoding?: string;
  "x-ros-type"?: string;
  "x-unit"?: string;
  "x-constants"?: Record<string, number>;
}

export function isObject(json: Json | undefined): json is JsonObject {
  return typeof json === "object" && json !== null && !Array.isArray(json);
}

export function isArray(json: Json | undefined): json is readonly Json[] {
  return Array.isArray(json);
}

/** Whether two documents are the same; the order of names does not count. */
export function same(a: Json | undefined, b: Json | undefined): boolean {
  if (isArray(a) && isArray(b))
    return a.length === b.length && a.every((item, index) => same(item, b[index]));
  if (isObject(a) && isObject(b)) {
    const names = Object.keys(a);
    return (
      names.length === Object.keys(b).length && names.every((name) => name in b && same(a[name], b[name]))
    );
  }
  return a === b;
}
