export * from "./errors.ts";
export * from "./http.ts";
export type { components, paths } from "./schema.gen.ts";
export type * from "./types.ts";
