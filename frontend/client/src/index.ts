export * from "./client.ts";
export * from "./errors.ts";
export * from "./goal.ts";
export * from "./http.ts";
export type { components, paths } from "./schema.gen.ts";
export * from "./stream.ts";
export type * from "./types.ts";
